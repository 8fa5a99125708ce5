// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/scene.h"

#include "simulator/motion.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace cell {

namespace {

using Vec = Eigen::Vector3d;

void
add(Solids& solids,
    const Vec& centre,
    const Vec& size,
    Material material,
    double yaw = 0.0)
{
  solids.emplace_back(uprightBox(centre, size, material, yaw));
}

void
addPipe(
    Solids& solids, const Vec& from, const Vec& to, double radius, Material material)
{
  solids.emplace_back(Capsule{from, to, radius, material});
}

/** \brief A table with four legs; `top` is the centre of the upper face. */
void
addTable(Solids& solids, const Vec& top, double length, double width, double yaw)
{
  const Eigen::AngleAxisd turn(yaw, Vec::UnitZ());
  add(solids,
      top - Vec(0, 0, 0.03),
      Vec(length, width, 0.06),
      Material::PaintedSteel,
      yaw);
  for (const double x : {-0.45 * length, 0.45 * length})
    for (const double y : {-0.42 * width, 0.42 * width}) {
      const Vec foot = Vec(top.x(), top.y(), 0) + turn * Vec(x, y, 0);
      addPipe(solids,
              foot,
              foot + Vec(0, 0, top.z() - 0.05),
              0.035,
              Material::PaintedSteel);
    }
}

/** \brief A row of fence posts with three rails; the wire mesh between is too fine for
 * a depth camera. */
void
addFence(Solids& solids, const Vec& from, const Vec& to, int fields)
{
  for (int i = 0; i <= fields; ++i) {
    const Vec foot = from + (to - from) * (static_cast<double>(i) / fields);
    addPipe(solids, foot, foot + Vec(0, 0, 2.0), 0.035, Material::PaintedSteel);
  }
  for (const double height : {0.25, 1.1, 1.95})
    addPipe(solids,
            from + Vec(0, 0, height),
            to + Vec(0, 0, height),
            0.025,
            Material::PaintedSteel);
}

void
addHall(Solids& solids)
{
  // The walls stand 1.5 m outside of the cell: the depth noise of a wall then does not
  // reach into it.
  add(solids, Vec(5, 5, -0.5), Vec(40, 40, 1), Material::Concrete);
  add(solids, Vec(-2.0, 5, 3), Vec(1, 40, 6), Material::Plaster);
  add(solids, Vec(12.0, 5, 3), Vec(1, 40, 6), Material::Plaster);
  add(solids, Vec(5, -2.0, 3), Vec(40, 1, 6), Material::Plaster);
  add(solids, Vec(5, 12.0, 3), Vec(40, 1, 6), Material::Plaster);
}

/** \brief A floor rail along y with its two guides. */
void
addRail(Solids& solids, double x, double from_y, double to_y)
{
  const double y = (from_y + to_y) / 2.0;
  const double length = to_y - from_y;
  add(solids, Vec(x, y, 0.09), Vec(0.5, length, 0.18), Material::PaintedSteel);
  for (const double side : {-0.18, 0.18})
    add(solids, Vec(x + side, y, 0.21), Vec(0.06, length, 0.06), Material::BareSteel);
}

/** \brief Columns and runway beams of the gantry, rails of the two floor robots. */
void
addRunways(Solids& solids)
{
  for (const double x : {0.9, 4.9})
    for (const double y : {5.4, 9.2})
      add(solids, Vec(x, y, 1.6), Vec(0.15, 0.15, 3.2), Material::PaintedSteel);
  for (const double x : {0.9, 4.9})
    add(solids, Vec(x, 7.3, 3.3), Vec(0.18, 4.0, 0.25), Material::PaintedSteel);
  addRail(solids, 2.6, 2.2, 7.0);
  addRail(solids, 7.4, 4.0, 8.0);
}

void
addMachines(Solids& solids)
{
  // Cabinets and shelves along the far sides.
  for (int i = 0; i < 3; ++i)
    add(solids,
        Vec(1.2 + 1.05 * i, 9.65, 1.0),
        Vec(1.0, 0.5, 2.0),
        i == 1 ? Material::DarkPlastic : Material::PaintedSteel);
  add(solids, Vec(0.35, 7.2, 0.9), Vec(0.5, 1.0, 1.8), Material::PaintedSteel);
  add(solids, Vec(0.35, 5.6, 1.05), Vec(0.5, 0.8, 2.1), Material::DarkPlastic);
  add(solids, Vec(9.6, 8.0, 1.0), Vec(0.6, 1.4, 2.0), Material::PaintedSteel);
  add(solids, Vec(9.6, 2.6, 0.9), Vec(0.6, 1.0, 1.8), Material::PaintedSteel);
  // A machine tool with its window and swarf bin.
  add(solids, Vec(6.4, 9.2, 0.8), Vec(1.3, 0.9, 1.6), Material::PaintedSteel);
  add(solids, Vec(6.4, 8.74, 1.0), Vec(0.6, 0.06, 0.5), Material::DarkPlastic);
  add(solids, Vec(5.0, 7.9, 0.35), Vec(0.6, 0.6, 0.7), Material::BareSteel);
  // Work tables with parts on them.
  addTable(solids, Vec(4.2, 3.3, 0.85), 1.4, 0.75, 0.3);
  add(solids, Vec(4.0, 3.2, 1.0), Vec(0.35, 0.25, 0.3), Material::BareSteel, 0.5);
  add(solids, Vec(4.6, 3.5, 0.95), Vec(0.3, 0.4, 0.2), Material::Cardboard, 0.1);
  addTable(solids, Vec(4.3, 7.4, 0.85), 1.4, 0.8, -0.2);
  add(solids, Vec(4.2, 7.5, 0.98), Vec(0.5, 0.3, 0.26), Material::PaintedSteel, 0.4);
  addTable(solids, Vec(0.7, 1.7, 0.9), 1.2, 0.7, 1.57);
  // Pallets with cartons.
  add(solids, Vec(3.7, 9.0, 0.07), Vec(1.2, 0.8, 0.14), Material::Cardboard, 0.1);
  add(solids, Vec(3.6, 9.0, 0.44), Vec(0.8, 0.7, 0.6), Material::Cardboard, 0.1);
  add(solids, Vec(8.6, 6.2, 0.5), Vec(1.1, 0.8, 1.0), Material::Cardboard, 1.5);
}

/** \brief The conveyor between the rails, with cartons on its belt. */
void
addConveyor(Solids& solids)
{
  add(solids, Vec(5.9, 4.6, 0.72), Vec(0.5, 4.0, 0.12), Material::DarkPlastic);
  for (const double side : {-0.28, 0.28})
    add(solids,
        Vec(5.9 + side, 4.6, 0.75),
        Vec(0.05, 4.0, 0.2),
        Material::PaintedSteel);
  for (int i = 0; i < 4; ++i)
    for (const double side : {-0.25, 0.25})
      addPipe(solids,
              Vec(5.9 + side, 2.9 + 1.13 * i, 0),
              Vec(5.9 + side, 2.9 + 1.13 * i, 0.66),
              0.03,
              Material::BareSteel);
  for (int i = 0; i < 3; ++i)
    add(solids,
        Vec(5.9, 3.4 + 1.2 * i, 0.92),
        Vec(0.35, 0.3, 0.28),
        Material::Cardboard,
        0.2 * i);
}

/** \brief Pipes, cable trays and the fence. */
void
addServices(Solids& solids)
{
  addPipe(
      solids, Vec(0.15, 0.5, 2.6), Vec(0.15, 9.8, 2.6), 0.08, Material::PaintedSteel);
  addPipe(
      solids, Vec(0.15, 9.8, 2.6), Vec(8.0, 9.8, 2.6), 0.08, Material::PaintedSteel);
  addPipe(solids, Vec(0.2, 9.7, 0.0), Vec(0.2, 9.7, 2.6), 0.08, Material::PaintedSteel);
  addPipe(solids, Vec(0.15, 4.3, 0.0), Vec(0.15, 4.3, 2.6), 0.05, Material::BareSteel);
  add(solids, Vec(4.0, 9.85, 2.9), Vec(7.0, 0.2, 0.08), Material::BareSteel);
  addFence(solids, Vec(0.1, 0.6, 0), Vec(0.1, 9.5, 0), 8);
  addFence(solids, Vec(0.6, 9.9, 0), Vec(9.4, 9.9, 0), 8);
  addFence(solids, Vec(9.9, 0.6, 0), Vec(9.9, 9.5, 0), 8);
}

/** \brief Joints of an arm, radians; all zero is stretched along its base's axis. */
struct ArmJoints {
  double turn;     ///< about the base's axis
  double shoulder; ///< away from the base's axis
  double elbow;    ///< relative to the upper arm
  double wrist;    ///< relative to the forearm
};

/** \brief Where the parts of an arm are, world. */
struct ArmPose {
  Vec shoulder, elbow, wrist, flange;
  Vec hand;     ///< unit vector from the wrist to the flange
  Vec sideways; ///< unit vector along the axes of shoulder, elbow and wrist
};

/** \brief Where the joints put an arm of the 100 kg class, 2.4 m reach.
 * \param[in] foot where the base stands (or hangs)
 * \param[in] up +1: standing, -1: hanging
 */
ArmPose
armPose(const Vec& foot, double up, const ArmJoints& joints)
{
  const auto direction = [&](double lean) {
    return Vec(std::sin(lean) * std::cos(joints.turn),
               std::sin(lean) * std::sin(joints.turn),
               up * std::cos(lean));
  };
  ArmPose arm;
  arm.shoulder = foot + Vec(0, 0, up * 0.55);
  const Vec upper = direction(joints.shoulder);
  const Vec fore = direction(joints.shoulder + joints.elbow);
  arm.hand = direction(joints.shoulder + joints.elbow + joints.wrist);
  arm.elbow = arm.shoulder + 1.1 * upper;
  arm.wrist = arm.elbow + 1.0 * fore;
  arm.flange = arm.wrist + 0.3 * arm.hand;
  arm.sideways = Vec(-std::sin(joints.turn), std::cos(joints.turn), 0);
  return arm;
}

/** \brief An arm with its gripper; parameters as above. */
void
addArm(Solids& solids, const Vec& foot, double up, const ArmJoints& joints)
{
  const auto [shoulder, elbow, wrist, flange, hand, sideways] =
      armPose(foot, up, joints);
  addPipe(solids, foot, shoulder, 0.26, Material::PaintedSteel);
  addPipe(solids,
          shoulder - 0.2 * sideways,
          shoulder + 0.2 * sideways,
          0.2,
          Material::PaintedSteel);
  addPipe(solids, shoulder, elbow, 0.13, Material::PaintedSteel);
  addPipe(solids,
          elbow - 0.12 * sideways,
          elbow + 0.12 * sideways,
          0.15,
          Material::PaintedSteel);
  addPipe(solids, elbow, wrist, 0.10, Material::PaintedSteel);
  addPipe(solids, wrist, flange, 0.07, Material::BareSteel);
  // The gripper: a bar across the flange with two fingers.
  const Vec finger_root = 0.15 * sideways;
  addPipe(
      solids, flange - finger_root, flange + finger_root, 0.04, Material::DarkPlastic);
  for (const double side : {-1.0, 1.0})
    addPipe(solids,
            flange + side * finger_root,
            flange + side * finger_root + 0.18 * hand,
            0.025,
            Material::BareSteel);
}

/** \brief An arm that stands on its carriage on a rail. */
struct RailArm {
  Vec foot;
  ArmJoints joints;
};

void
addRailArm(Solids& solids, const RailArm& arm)
{
  const Vec carriage(arm.foot.x(), arm.foot.y(), 0.31);
  add(solids, carriage, Vec(0.7, 0.8, 0.14), Material::PaintedSteel);
  addArm(solids, arm.foot, 1.0, arm.joints);
}

/** \brief The arm on the rail at x = 2.6 m; values are y on the rail and the joints. */
RailArm
firstRailArm(double time)
{
  static const Track<5> track({{0.0, {3.0, 0.3, 0.3, 1.5, 0.6}},
                               {2.0, {3.0, 0.2, 0.9, 1.0, 0.8}},
                               {3.0, {3.0, 0.2, 0.9, 1.0, 0.8}},
                               {6.0, {6.2, 1.4, 0.2, 1.4, 0.7}},
                               {8.5, {6.2, 1.4, 0.2, 1.4, 0.7}},
                               {10.5, {6.2, 0.4, 0.8, 1.2, 0.7}},
                               {11.5, {6.2, 0.4, 0.8, 1.2, 0.7}},
                               {15.0, {3.0, 0.3, 0.3, 1.5, 0.6}}});
  const auto value = track.at(time);
  return {Vec(2.6, value[0], 0.38), {value[1], value[2], value[3], value[4]}};
}

/** \brief The arm on the rail at x = 7.4 m. */
RailArm
secondRailArm(double time)
{
  static const Track<5> track({{0.0, {6.6, 2.8, 0.4, 1.3, 0.5}},
                               {1.5, {6.6, 2.8, 0.4, 1.3, 0.5}},
                               {4.0, {4.6, 3.3, 0.9, 1.1, 0.6}},
                               {8.0, {4.6, 3.3, 0.9, 1.1, 0.6}},
                               {9.5, {4.6, 2.9, 0.5, 1.5, 0.8}},
                               {12.5, {6.6, 1.9, 0.5, 1.5, 0.8}},
                               {13.5, {6.6, 1.9, 0.5, 1.5, 0.8}},
                               {15.0, {6.6, 2.8, 0.4, 1.3, 0.5}}});
  const auto value = track.at(time);
  return {Vec(7.4, value[0], 0.38), {value[1], value[2], value[3], value[4]}};
}

/** \brief Bridge, trolley and hanging arm of the gantry; values are the bridge's y, the
 * trolley's x and the joints. */
void
addGantryArm(Solids& solids, double time)
{
  static const Track<6> track({{0.0, {7.4, 3.6, 0.5, 0.5, 0.9, 0.3}},
                               {1.0, {7.4, 3.6, 0.5, 0.5, 0.9, 0.3}},
                               {3.5, {6.4, 3.2, 1.5, 0.7, 0.6, 0.4}},
                               {5.0, {6.4, 3.2, 1.5, 0.7, 0.6, 0.4}},
                               {6.5, {6.4, 3.2, 2.2, 0.4, 0.8, 0.4}},
                               {8.0, {6.4, 3.2, 2.2, 0.4, 0.8, 0.4}},
                               {12.0, {7.4, 4.2, 0.8, 0.8, 0.7, 0.2}},
                               {13.0, {7.4, 4.2, 0.8, 0.8, 0.7, 0.2}},
                               {15.0, {7.4, 3.6, 0.5, 0.5, 0.9, 0.3}}});
  const auto value = track.at(time);
  add(solids, Vec(2.9, value[0], 3.5), Vec(4.0, 0.3, 0.3), Material::PaintedSteel);
  add(solids, Vec(value[1], value[0], 3.2), Vec(0.6, 0.6, 0.3), Material::PaintedSteel);
  addArm(solids,
         Vec(value[1], value[0], 3.05),
         -1.0,
         ArmJoints{value[2], value[3], value[4], value[5]});
}

/** \brief A person of 1.8 m who walks up and down the aisle beside a rail. */
void
addPerson(Solids& solids, double time)
{
  // Position and heading; the person turns on the spot at each end.
  static const Track<3> track({{0.0, {1.6, 8.9, -1.55}},
                               {4.5, {1.7, 3.6, -1.55}},
                               {5.5, {1.7, 3.6, 0.0}},
                               {9.0, {1.7, 3.6, 0.0}},
                               {10.0, {1.7, 3.6, 1.59}},
                               {14.0, {1.6, 8.9, 1.59}},
                               {15.0, {1.6, 8.9, -1.55}}});
  const auto value = track.at(time);
  const Vec feet(value[0], value[1], 0);
  const Vec ahead(std::cos(value[2]), std::sin(value[2]), 0);
  const Vec left(-ahead.y(), ahead.x(), 0);
  // The swing depends on the distance walked: the legs rest when the person does.
  constexpr double stride = 1.4;
  const double swing = 0.45 * std::sin(2.0 * pi * value[1] / stride);
  const Vec hip = feet + Vec(0, 0, 0.95);
  const Vec neck = feet + Vec(0, 0, 1.48);
  for (const double side : {-1.0, 1.0}) {
    const Vec leg = Vec(0, 0, -0.86) + side * swing * ahead;
    const Vec arm = Vec(0, 0, -0.6) - side * 0.7 * swing * ahead;
    const Vec hip_joint = hip + side * 0.11 * left;
    const Vec shoulder = neck + side * 0.22 * left;
    addPipe(solids, hip_joint, hip_joint + leg, 0.08, Material::Cloth);
    addPipe(solids, shoulder, shoulder + arm, 0.05, Material::Cloth);
  }
  addPipe(solids, hip + Vec(0, 0, 0.1), neck - Vec(0, 0, 0.08), 0.17, Material::Cloth);
  const Vec head = feet + Vec(0, 0, 1.67);
  addPipe(solids, head, head, 0.12, Material::Cloth);
}

} // namespace

Solids
staticEquipment()
{
  Solids solids;
  addHall(solids);
  addRunways(solids);
  addMachines(solids);
  addConveyor(solids);
  addServices(solids);
  return solids;
}

Solids
movingMachines(double time)
{
  Solids solids;
  addRailArm(solids, firstRailArm(time));
  addRailArm(solids, secondRailArm(time));
  addGantryArm(solids, time);
  return solids;
}

Eigen::Isometry3d
handPose(double time)
{
  const auto [foot, joints] = firstRailArm(time);
  const ArmPose arm = armPose(foot, 1.0, joints);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(0) = -arm.sideways;
  pose.linear().col(1) = arm.sideways.cross(arm.hand);
  pose.linear().col(2) = arm.hand;
  pose.translation() = arm.flange;
  return pose;
}

Solids
walkingPerson(double time)
{
  Solids solids;
  addPerson(solids, time);
  return solids;
}

} // namespace cell
} // namespace pcl_ext
