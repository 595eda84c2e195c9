// One client's side of a serial port that is reached by RFC 2217: telnet whose COM-PORT option
// carries the port's settings. No file descriptor, so every exchange can be tested byte for byte.
//
//   client -- data ------> SerialLine::host_send
//   client -- settings --> SerialLine::set_host
//   client <-- data ------ ClientOutbox::pending
//   client <-- answers --- ClientOutbox::wire
//
// The answer to a setting says what is in use afterwards: the value asked for, or, where the line
// cannot have it (mark parity, flow control, a baud rate outside of 50..4000000), what it was.
// Accepted without effect, because a drive's line is three wires: DTR, RTS and break. Modem inputs
// read as always on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pty/serial_line.h"

namespace virtdrive {

/// What waits to go to a client.
struct ClientOutbox {
  std::vector<std::uint8_t> pending;  // from the device, as it sent them
  std::vector<std::uint8_t> wire;     // as they go over the network
};

class Rfc2217Session {
 public:
  /// Bytes of one subnegotiation; a longer one is ignored. The longest we act on has 6.
  static constexpr std::size_t kMaxCommand = 64;

  /// Puts our telnet offers into the outbox. Line and outbox must outlive the session.
  Rfc2217Session(SerialLine& line, ClientOutbox& outbox);

  /// Takes in what the client sent, in pieces of any size. The answers are at most three times as
  /// long. Returns how many commands it ignored because they were malformed or unknown.
  std::size_t hear(std::span<const std::uint8_t> bytes);
  /// Moves what the device sent to the wire, unless the client has asked us to hold it back.
  void encode_pending();

 private:
  enum class State : std::uint8_t { kData, kCommand, kOption, kSub, kSubCommand };
  enum class Agreed : std::uint8_t { kNo, kOffered, kYes };
  struct Option {
    std::uint8_t code;
    Agreed ours;    // WILL and DO
    Agreed theirs;  // DO and WILL
  };
  struct Command;
  static const Command kCommands[];

  void hear(std::uint8_t byte);
  void hear_command(std::uint8_t byte);
  void hear_sub(std::uint8_t byte);
  void send_data();
  void negotiate(std::uint8_t verb, std::uint8_t code);
  void execute_sub();
  void tell(std::uint8_t verb, std::uint8_t option);
  void answer(std::uint8_t code, std::span<const std::uint8_t> value);
  void answer(std::uint8_t code, std::uint8_t value);

  void signature(std::uint32_t);
  void set_baud(std::uint32_t baud);
  void set_data_bits(std::uint32_t bits);
  void set_parity(std::uint32_t parity);
  void set_stop_bits(std::uint32_t bits);
  void control(std::uint32_t request);
  void line_state(std::uint32_t);
  void modem_state(std::uint32_t);
  void suspend(std::uint32_t);
  void resume(std::uint32_t);
  void line_state_mask(std::uint32_t mask);
  void modem_state_mask(std::uint32_t mask);
  void purge(std::uint32_t what);

  SerialLine& line_;
  ClientOutbox& outbox_;
  std::vector<Option> options_;
  State state_ = State::kData;
  std::uint8_t verb_ = 0;
  std::vector<std::uint8_t> data_;
  std::vector<std::uint8_t> sub_;
  std::size_t ignored_ = 0;
  bool suspended_ = false;
  bool break_ = false;
  bool dtr_ = true;
  bool rts_ = true;
  std::uint8_t line_state_mask_ = 0;      // RFC 2217, section 3: initially none,
  std::uint8_t modem_state_mask_ = 0xFF;  // and all
};

}  // namespace virtdrive
