// The JSON schema (draft 2020-12) of scenario files, for editors that complete and check YAML by
// it. Made from the tables: the language's words, drives, motors, parameters, commands, errors.
#pragma once

#include <string>

namespace virtdrive {

/// Indented JSON; the same program gives the same text.
std::string scenario_schema();

}  // namespace virtdrive
