#include "devices/md485/client.h"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <utility>

#include "core/check.h"
#include "devices/protocol/binding.h"

namespace virtdrive::md485 {
namespace {

constexpr std::uint8_t kRequestData = 4, kRequestIndexed = 164;
constexpr std::uint8_t kId = 133;
constexpr std::uint16_t kIndexed[] = {225, 226, 227};

const CommandRow& command_row(std::uint8_t pid) {
  const CommandRow* row = protocol::find(kTable.commands, pid);
  VIRTDRIVE_CHECK(row != nullptr, "no command {}", pid);
  return *row;
}

}  // namespace

protocol::Values Client::read(const ParameterRow& row) {
  command(command_row(kRequestData), {row.id});
  return receive(row);
}

protocol::Values Client::read(const ParameterRow& row, std::uint8_t index) {
  command(command_row(kRequestIndexed), {row.id, index});
  return receive(row);
}

void Client::write(const ParameterRow& row, const protocol::Values& values) {
  protocol::Values all;
  if (is_checked(row.id)) all.push(kWriteCheck);
  for (std::size_t i = 0; i < values.size(); ++i) all.push(values[i]);
  transport_.write(encode_request(route_, row, all));
}

// It answers to its new number now, if it took it.
void Client::follow_id(std::uint8_t id) {
  const std::uint8_t before = std::exchange(route_.id, id);
  std::int64_t held = before;
  try {
    held = read(*protocol::find(kTable.parameters, kId))[0];
  } catch (const DriveSilent&) {
  }
  if (held == id) return;
  route_.id = before;
  throw DriveRefused(fmt::format("PID_ID: wrote {}, no controller has it", id), held);
}

void Client::set(const ParameterRow& row, const protocol::Values& values) {
  write(row, values);
  if (row.access != Access::kReadWrite || route_.id == kAllControllers) return;
  if (row.id == kId) return follow_id(static_cast<std::uint8_t>(values[0]));
  const bool indexed = std::ranges::find(kIndexed, row.id) != std::end(kIndexed);
  const protocol::Values held =
      indexed ? read(row, static_cast<std::uint8_t>(values[0])) : read(row);
  for (std::size_t i = 0; i < std::min(values.size(), held.size()); ++i) {
    if (held[i] == values[i]) continue;
    throw DriveRefused(
        fmt::format("{}: wrote {}, the controller holds {}", row.name, values[i], held[i]),
        held[i]);
  }
}

void Client::command(const CommandRow& row, const protocol::Values& values) {
  transport_.write(encode_request(route_, row, values));
}

protocol::Values Client::receive(const ParameterRow& row) {
  Decoder decoder(protocol::Direction::kReply, route_.host);
  while (true) {
    const auto byte = transport_.read(patience_);
    if (!byte) throw DriveSilent(fmt::format("{}: the controller does not answer", row.name));
    for (auto e = decoder.push(*byte); e != Decoder::Event::kNone; e = decoder.next()) {
      if (e == Decoder::Event::kFrame && decoder.frame().pid == row.id) {
        return decoder.frame().values;
      }
    }
  }
}

}  // namespace virtdrive::md485
