#include "devices/md485/can_codec.h"

#include "core/check.h"
#include "devices/md485/model_table.h"
#include "devices/protocol/checksum.h"

namespace virtdrive::md485 {
namespace {

constexpr std::uint8_t kResendPid = 238;

std::uint32_t identifier(std::uint8_t to, std::uint8_t from, std::uint8_t id) {
  return std::uint32_t{to} << 16 | std::uint32_t{from} << 8 | id;
}

std::optional<CanFrame> pack(std::uint32_t identifier, std::uint16_t pid,
                             std::span<const Field> fields, const protocol::Values& values) {
  std::vector<std::uint8_t> bytes = {static_cast<std::uint8_t>(pid)};
  protocol::pack(fields, kTable.framing.order, values, bytes);
  if (bytes.size() > 1 + kMostCanData) return std::nullopt;
  return extended_frame(identifier, bytes);
}

CanFrame fitting(const std::optional<CanFrame>& frame, std::string_view name) {
  VIRTDRIVE_CHECK(frame.has_value(), "{} does not fit into a CAN frame", name);
  return *frame;
}

}  // namespace

CanFrame can_request(Route route, const CommandRow& row, const protocol::Values& values) {
  return fitting(pack(identifier(kController, route.host, route.id), row.code, row.request, values),
                 row.name);
}

CanFrame can_request(Route route, const ParameterRow& row, const protocol::Values& values) {
  return fitting(
      pack(identifier(kController, route.host, route.id), row.id, write_fields(row), values),
      row.name);
}

std::optional<CanFrame> can_reply(Route route, const ParameterRow& row,
                                  const protocol::Values& values) {
  return pack(identifier(route.host, kController, route.id), row.id, protocol::value_fields(row),
              values);
}

std::optional<Frame> can_route(protocol::Direction direction, const CanFrame& frame,
                               std::uint8_t host) {
  const auto to = static_cast<std::uint8_t>(frame.id >> 16);
  const auto from = static_cast<std::uint8_t>(frame.id >> 8);
  if (!frame.extended || frame.id >> 24 != 0 || frame.bytes().empty()) return std::nullopt;
  const bool request = direction == protocol::Direction::kRequest;
  if (request ? to != kController : (to != host || from != kController)) return std::nullopt;
  return Frame{.route = {.host = request ? from : to, .id = static_cast<std::uint8_t>(frame.id)},
               .pid = frame.data[0]};
}

std::span<const std::uint8_t> can_data(const CanFrame& frame) {
  return frame.bytes().subspan(1);
}

std::vector<std::uint8_t> encode_can_resend(Route route, const CanFrame& heard) {
  std::vector<std::uint8_t> bytes = {route.host, kController, route.id, kResendPid,
                                     static_cast<std::uint8_t>(4 + heard.bytes().size())};
  for (int byte = 0; byte < 4; ++byte) {
    bytes.push_back(static_cast<std::uint8_t>(heard.id >> (8 * byte)));
  }
  bytes.insert(bytes.end(), heard.bytes().begin(), heard.bytes().end());
  bytes.push_back(protocol::negated_sum8(bytes));
  return bytes;
}

}  // namespace virtdrive::md485
