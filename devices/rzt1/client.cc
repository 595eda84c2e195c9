#include "devices/rzt1/client.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/check.h"

namespace virtdrive::rzt1 {
namespace {

constexpr std::uint8_t kCall = 2, kStream = 4, kSet = 5, kGet = 6, kTraceBuffer = 7;
constexpr std::int64_t kLongSamples = 0x80;

const CommandRow& packet_row(std::uint8_t code) {
  const CommandRow* row = protocol::find(kTable.commands, code);
  VIRTDRIVE_CHECK(row != nullptr, "no packet {}", code);
  return *row;
}

template <class Row>
const Row& named(const Row* row, std::string_view name) {
  VIRTDRIVE_CHECK(row != nullptr, "no {}", name);
  return *row;
}

std::string name_of(const Packet& packet) {
  if (packet.function != nullptr) return std::string(packet.function->name);
  if (packet.parameter != nullptr) return std::string(packet.parameter->name);
  return std::string(packet.row->name);
}

std::string_view name_of(Status status) {
  const auto row =
      std::ranges::find(kTable.errors, static_cast<std::int32_t>(status), &CodeRow::code);
  return row != kTable.errors.end() ? row->name : "unknown";
}

}  // namespace

std::int32_t velocity_units(double counts_per_s, SimDuration cycle) {
  return static_cast<std::int32_t>(counts_per_s * seconds(cycle) * 65536);
}

std::int32_t acceleration_units(double counts_per_s2, SimDuration cycle) {
  return static_cast<std::int32_t>(counts_per_s2 * seconds(cycle) * seconds(cycle) * 65536);
}

const ParameterRow* find_variable(std::string_view name) {
  const auto row = std::ranges::find(kTable.parameters, name, &ParameterRow::name);
  return row != kTable.parameters.end() ? &*row : nullptr;
}

const CommandRow* find_function(std::string_view name) {
  const auto row = std::ranges::find(kTable.functions, name, &CommandRow::name);
  return row != kTable.functions.end() ? &*row : nullptr;
}

// --- Packets -------------------------------------------------------------------------------------

PacketReplyDecoder Client::exchange(const Packet& packet) {
  PacketReplyDecoder decoder(packet);
  transport_.write(encode_request(packet));
  if (packet.address == kAllModules) return decoder;
  while (true) {
    const auto byte = transport_.read(patience_);
    if (!byte) throw DriveSilent(fmt::format("{}: no answer", name_of(packet)));
    switch (decoder.push(*byte)) {
      case PacketReplyDecoder::Event::kNone:
        break;
      case PacketReplyDecoder::Event::kBadSum:
        throw ClientError(fmt::format("{}: an answer with a wrong sum", name_of(packet)));
      case PacketReplyDecoder::Event::kReply:
        if (decoder.status() == Status::kOk) return decoder;
        throw DriveRefused(
            fmt::format("{}: refused, {}", name_of(packet), name_of(decoder.status())),
            static_cast<std::int64_t>(decoder.status()));
    }
  }
}

protocol::Values Client::send(const CommandRow& row, const protocol::Values& values) {
  Packet packet{.address = address_, .row = &row, .values = values};
  const auto id = static_cast<std::uint16_t>(values.size() > 0 ? values[0] : 0);
  if (row.names == Names::kFunction) packet.function = protocol::find(kTable.functions, id);
  if (row.names == Names::kParameter) packet.parameter = protocol::find(kTable.parameters, id);
  if (row.names == Names::kParameter && packet.parameter == nullptr) {
    packet.function = protocol::find(kTable.functions, id);
  }
  return exchange(packet).values();
}

std::int64_t Client::get(std::string_view variable) {
  const protocol::Values values =
      send(packet_row(kGet), {named(find_variable(variable), variable).id});
  return values.size() > 0 ? values[0] : 0;
}

void Client::set(std::string_view variable, std::int64_t value) {
  send(packet_row(kSet), {named(find_variable(variable), variable).id, value});
}

void Client::call(std::string_view function) {
  send(packet_row(kCall), {named(find_function(function), function).code});
}

std::vector<std::int32_t> Client::trace(std::uint8_t buffer, TraceWidth width) {
  const PacketReplyDecoder reply =
      exchange({.address = address_,
                .row = &packet_row(kTraceBuffer),
                .values = {buffer | (width == TraceWidth::kFourBytes ? kLongSamples : 0)}});
  return {reply.samples().begin(), reply.samples().end()};
}

void Client::stream(std::span<const Point> points) {
  VIRTDRIVE_CHECK(points.size() <= kMostPoints, "{} points in a packet", points.size());
  protocol::Values values = {static_cast<std::int64_t>(points.size())};
  for (const Point& point : points) {
    values.push(point.position);
    values.push(point.velocity);
  }
  exchange({.address = address_, .row = &packet_row(kStream), .values = values});
}

// --- Lines ---------------------------------------------------------------------------------------

std::string Client::line(std::string_view text) {
  std::vector<std::uint8_t> request(text.begin(), text.end());
  request.push_back('\r');
  transport_.write(request);
  LineReplyDecoder decoder;
  std::string said;
  while (true) {
    const auto byte = transport_.read(patience_);
    if (!byte) throw DriveSilent(fmt::format("{}: no prompt", text));
    switch (decoder.push(*byte)) {
      case LineReplyDecoder::Event::kNone:
        break;
      case LineReplyDecoder::Event::kText:
        if (!said.empty()) said += "\n";
        said += decoder.text();
        break;
      case LineReplyDecoder::Event::kAccepted:
        return said;
      case LineReplyDecoder::Event::kRefused:
        throw DriveRefused(fmt::format("{}: refused", text), 0);
    }
  }
}

}  // namespace virtdrive::rzt1
