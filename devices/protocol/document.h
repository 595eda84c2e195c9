// A protocol's page, made from its tables: every command, parameter, error and fault.
#pragma once

#include <string>

#include "devices/protocol/table.h"

namespace virtdrive::protocol {

/// Markdown. The same table gives the same text.
std::string document(const ProtocolTable& table);

/// Words for a reader: "implemented", "documented", "R/W", ...
std::string_view word(Support support);
std::string_view word(Evidence evidence);
std::string_view word(Access access);
/// "mA|A", or the one unit there is.
std::string units(const ParameterRow& row);
/// "0 ... 10", "text, 20 bytes".
std::string range(const ParameterRow& row);
/// The factory value with its unit, empty where there is none.
std::string factory(const ParameterRow& row);

}  // namespace virtdrive::protocol
