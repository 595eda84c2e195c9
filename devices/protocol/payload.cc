#include "devices/protocol/payload.h"

#include <fmt/format.h>

namespace virtdrive::protocol {
namespace {

// Calls visit(field) once for each number of the fields, in wire order.
template <class Visitor>
void for_each_number(std::span<const Field> fields, Visitor&& visit) {
  for (const Field& field : fields) {
    for (std::size_t i = 0; i < field.count; ++i) {
      VIRTDRIVE_CHECK(field.type != WireType::kParameter, "{}: whose value?", field.name);
      if (field.members.empty())
        visit(field);
      else
        for_each_number(field.members, visit);
    }
  }
}

}  // namespace

void store(std::span<std::uint8_t> bytes, WireType type, ByteOrder order, std::int64_t value) {
  const std::size_t n = width(type);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t place = order == ByteOrder::kLittleEndian ? i : n - 1 - i;
    bytes[place] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
}

std::int64_t load(std::span<const std::uint8_t> bytes, WireType type, ByteOrder order) {
  const std::size_t n = width(type);
  std::uint64_t raw = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t place = order == ByteOrder::kLittleEndian ? i : n - 1 - i;
    raw |= static_cast<std::uint64_t>(bytes[place]) << (8 * i);
  }
  if (!is_signed(type)) return static_cast<std::int64_t>(raw);
  const std::uint64_t sign = std::uint64_t{1} << (8 * n - 1);
  return static_cast<std::int64_t>((raw ^ sign) - sign);
}

void pack(std::span<const Field> fields, ByteOrder order, const Values& values,
          std::vector<std::uint8_t>& out) {
  std::size_t i = 0;
  for_each_number(fields, [&](const Field& field) {
    const std::size_t at = out.size();
    out.resize(at + width(field.type));
    store(std::span(out).subspan(at), field.type, order, values[i++]);
  });
  VIRTDRIVE_CHECK(i == values.size(), "{} values for {} fields", values.size(), i);
}

Values unpack(std::span<const Field> fields, ByteOrder order, std::span<const std::uint8_t> bytes) {
  VIRTDRIVE_CHECK(bytes.size() == width(fields), "{} bytes for {}", bytes.size(), width(fields));
  Values values;
  for_each_number(fields, [&](const Field& field) {
    values.push(load(bytes.first(width(field.type)), field.type, order));
    bytes = bytes.subspan(width(field.type));
  });
  return values;
}

std::optional<Values> unpack_some(std::span<const Field> fields, ByteOrder order,
                                  std::span<const std::uint8_t> bytes) {
  std::span<const Field> present = fields;
  while (!present.empty() && present.back().optional && width(present) > bytes.size()) {
    present = present.first(present.size() - 1);
  }
  if (width(present) > bytes.size()) return std::nullopt;
  Values values = unpack(present, order, bytes.first(width(present)));
  values.pad(fields);
  return values;
}

std::vector<Field> value_fields(const ParameterRow& row) {
  if (!row.fields.empty()) return {row.fields.begin(), row.fields.end()};
  return {{.name = row.name,
           .type = row.type,
           .count = row.count,
           .unit = row.unit,
           .scale = row.scale}};
}

std::vector<Field> with_value(std::span<const Field> fields, std::span<const Field> value) {
  std::vector<Field> whole;
  for (const Field& field : fields) {
    if (field.type == WireType::kParameter)
      whole.insert(whole.end(), value.begin(), value.end());
    else
      whole.push_back(field);
  }
  return whole;
}

std::vector<Field> masked(std::span<const Field> fields, std::int64_t mask) {
  std::vector<Field> chosen;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if ((mask >> i & 1) != 0) chosen.push_back(fields[i]);
  }
  return chosen;
}

std::string describe(std::span<const Field> fields, const Values& values) {
  std::string text;
  std::size_t i = 0;
  for_each_number(fields, [&](const Field& field) {
    if (i == values.size()) return;
    if (!text.empty()) text += ' ';
    const double scaled = static_cast<double>(values[i]) * field.scale;
    text += field.scale == 1 ? fmt::format("{}={}", field.name, values[i])
                             : fmt::format("{}={:.6g}", field.name, scaled);
    text += field.unit;
    ++i;
  });
  return text;
}

}  // namespace virtdrive::protocol
