#include "devices/md485/client.h"

#include <fmt/format.h>

#include "core/check.h"
#include "devices/protocol/binding.h"

namespace virtdrive::md485 {
namespace {

constexpr std::uint8_t kRequestData = 4, kRequestIndexed = 164;

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
