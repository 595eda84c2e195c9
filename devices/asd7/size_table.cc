#include "devices/asd7/size_table.h"

namespace virtdrive::asd7 {

SizeTable::SizeTable(const ProtocolTable& base, Parameters factory)
    : rows_(base.parameters.begin(), base.parameters.end()), table_(base) {
  for (ParameterRow& row : rows_) {
    if (const std::uint16_t* place = place_of(factory, row.id)) row.factory.value = *place;
  }
  table_.parameters = rows_;
}

}  // namespace virtdrive::asd7
