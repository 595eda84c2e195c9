// A protocol's table as one size has it: the rows are those of all sizes, with its factory values.
#pragma once

#include <vector>

#include "devices/asd7/eeprom.h"
#include "devices/asd7/table.h"

namespace virtdrive::asd7 {

class SizeTable {
 public:
  /// `base` lives as long as the program.
  SizeTable(const ProtocolTable& base, Parameters factory);
  SizeTable(const SizeTable&) = delete;
  SizeTable& operator=(const SizeTable&) = delete;

  const ProtocolTable& table() const { return table_; }

 private:
  std::vector<ParameterRow> rows_;
  ProtocolTable table_;
};

}  // namespace virtdrive::asd7
