#include "devices/asd7/client.h"

#include <fmt/format.h>

#include "core/check.h"

namespace virtdrive::asd7 {
namespace {

const CommandRow& command_row(char code) {
  const CommandRow* row = protocol::find(kTable.commands, static_cast<std::uint8_t>(code));
  VIRTDRIVE_CHECK(row != nullptr, "no command {}", code);
  return *row;
}

}  // namespace

std::int64_t Client::read(const ParameterRow& row) {
  return call(command_row('R'), {row.id})[1];
}

void Client::write(const ParameterRow& row, std::int64_t value, bool keep) {
  call(command_row(keep ? 'W' : 'P'), {row.id, value});
}

protocol::Values Client::call(const CommandRow& row, const protocol::Values& request) {
  // ASCII has not all commands.
  const bool binary = is_ascii(format_) && is_binary_only(row);
  const Message message{
      .format = binary ? Format::kBinary16 : format_,
      .number = number_,
      .row = &row,
      .parameter = protocol::find(kTable.parameters, static_cast<std::uint16_t>(request[0])),
      .values = request};
  transport_.write(encode_request(message));
  if (!row.replies) return {};
  const std::string what =
      message.parameter != nullptr
          ? fmt::format("{} {}", row.name, message.parameter->name)
          : fmt::format("{} {:04X}", row.name, static_cast<unsigned>(request[0]));
  const Message reply = receive(what);
  if (reply.row == &kErrorReply) {
    const std::int64_t code = reply.values[0];
    const CodeRow* known = nullptr;
    for (const CodeRow& error : kErrors) {
      if (error.code == code) known = &error;
    }
    throw DriveRefused(
        fmt::format("{}: the drive answers error {:04X}{}{}", what, code,
                    known != nullptr ? " " : "", known != nullptr ? known->name : ""),
        code);
  }
  if (reply.row != &row || reply.values[0] != request[0]) {
    throw ClientError(fmt::format("{}: the drive answers something else", what));
  }
  return reply.values;
}

Message Client::receive(std::string_view what) {
  Decoder decoder(protocol::Direction::kReply, true);
  while (const auto byte = transport_.read(patience_)) {
    if (decoder.push(*byte) != Decoder::Event::kMessage) continue;
    if (decoder.message().error) throw ClientError(fmt::format("{}: wrong checksum", what));
    return decoder.message();
  }
  throw DriveSilent(fmt::format("{}: the drive does not answer", what));
}

}  // namespace virtdrive::asd7
