// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "support/nats_server.h"

#include <gtest/gtest.h>

#include <nats/nats.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::link::test {

class Stranger {
public:
  explicit Stranger(const NatsServer& server)
  {
    EXPECT_EQ(natsConnection_ConnectTo(&connection_, server.url().c_str()), NATS_OK);
  }

  ~Stranger() { natsConnection_Destroy(connection_); }
  Stranger(const Stranger&) = delete;
  Stranger&
  operator=(const Stranger&) = delete;

  void
  publish(const std::string& subject,
          const std::string& header,
          const std::vector<std::uint8_t>& bytes)
  {
    natsMsg* message = nullptr;
    EXPECT_EQ(natsMsg_Create(&message,
                             subject.c_str(),
                             nullptr,
                             reinterpret_cast<const char*>(bytes.data()),
                             static_cast<int>(bytes.size())),
              NATS_OK);
    if (!header.empty()) {
      EXPECT_EQ(natsMsgHeader_Set(message, "Pcl-Ext-Frame", header.c_str()), NATS_OK);
    }
    EXPECT_EQ(natsConnection_PublishMsg(connection_, message), NATS_OK);
    natsMsg_Destroy(message);
    EXPECT_EQ(natsConnection_Flush(connection_), NATS_OK);
  }

private:
  natsConnection* connection_ = nullptr;
};

} // namespace pcl_ext::PCL_EXT_ABI::link::test
