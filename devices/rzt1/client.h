// A host's side of the RZ/T1 protocols, made from the same rows as the board: packets for numbers,
// lines for people.
//
//   Client client(transport, 2);                  // the module with address 2
//   client.set("KP", 1500);                       // packet 5
//   client.call("ON");                            // packet 2
//   client.line("2POS");                          // "0"
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "devices/host_transport.h"
#include "devices/rzt1/codec.h"

namespace virtdrive::rzt1 {

/// VEL of so many counts a second, the loop cycle being DS * 50 us; cut off as the document's
/// example does: 5000 counts/s at 100 us are 32768 (6.5.2).
std::int32_t velocity_units(double counts_per_s, SimDuration cycle);
/// ACC or DEC of so many counts a second squared: 30000 at 100 us are 19 (6.5.3).
std::int32_t acceleration_units(double counts_per_s2, SimDuration cycle);

class Client {
 public:
  /// `patience` holds for each byte of a reply.
  explicit Client(HostTransport& transport, std::uint8_t address = 1,
                  SimDuration patience = std::chrono::milliseconds(500))
      : transport_(transport), address_(address), patience_(patience) {}

  std::uint8_t address() const { return address_; }
  void set_address(std::uint8_t address) { address_ = address; }

  /// Sends a packet and waits for its answer; to 255 nobody answers, and nothing is waited for.
  /// DriveRefused with the status, DriveSilent, or ClientError for a wrong sum.
  protocol::Values send(const CommandRow& row, const protocol::Values& values);

  std::int64_t get(std::string_view variable);
  void set(std::string_view variable, std::int64_t value);
  void call(std::string_view function);
  /// A buffer (0..3) of the recorder.
  std::vector<std::int32_t> trace(std::uint8_t buffer, TraceWidth width);
  /// At most kMostPoints.
  struct Point {
    std::int32_t position, velocity;
  };
  void stream(std::span<const Point> points);

  /// A line without its CR; what it prints, without the last line's end. DriveRefused (code 0) at a
  /// question mark.
  std::string line(std::string_view text);

 private:
  PacketReplyDecoder exchange(const Packet& packet);

  HostTransport& transport_;
  std::uint8_t address_;
  SimDuration patience_;
};

/// Rows by name; null if there is none.
const ParameterRow* find_variable(std::string_view name);
const CommandRow* find_function(std::string_view name);

}  // namespace virtdrive::rzt1
