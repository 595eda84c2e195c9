// A motor on paper: its set with derived constants, as text and JSON, and what its file may hold as
// a JSON schema and a table for the documents.
#pragma once

#include <string>

#include "plant/motor_library.h"

namespace virtdrive {

std::string motor_text(const Motor& motor);

/// One object; keys carry their units, a value that does not exist is null.
std::string motor_json(const Motor& motor);

/// data/motors/motor.schema.json (JSON Schema 2020-12), for editors that check while one types.
std::string motor_schema();

/// Markdown: the keys of a file with unit, range and meaning (docs/motors.md).
std::string motor_key_table();

}  // namespace virtdrive
