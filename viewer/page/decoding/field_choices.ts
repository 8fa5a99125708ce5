// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { type FieldDescription, isPackedColour } from "@pcl_ext/codec";

/** A value of a field: the index of the field, and which of its values. */
export type FieldChoice = readonly [field: number, value: number];

/** What voxels can be coloured by, with names as the program gives them in PLY files: those of a field with several
 * values end in _0, _1 and so on. Packed colours are shown as colours. */
export function fieldChoices(fields: readonly FieldDescription[]): Map<string, FieldChoice> {
  const choices = new Map<string, FieldChoice>();
  fields.forEach((described, field) => {
    if (isPackedColour(described)) return;
    const { name, count } = described;
    for (let value = 0; value < count; ++value) {
      let unique = count > 1 ? `${name}_${value}` : name;
      while (choices.has(unique)) unique += "_";
      choices.set(unique, [field, value]);
    }
  });
  return choices;
}
