#include "pty/rfc2217_session.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace virtdrive {
namespace {

// RFC 854, RFC 855.
constexpr std::uint8_t kSe = 240;
constexpr std::uint8_t kSb = 250;
constexpr std::uint8_t kWill = 251;
constexpr std::uint8_t kWont = 252;
constexpr std::uint8_t kDo = 253;
constexpr std::uint8_t kDont = 254;
constexpr std::uint8_t kIac = 255;

constexpr std::uint8_t kBinary = 0;           // RFC 856
constexpr std::uint8_t kSuppressGoAhead = 3;  // RFC 858
constexpr std::uint8_t kComPort = 44;         // RFC 2217

constexpr std::uint8_t kServer = 100;  // an answer's code is the command's plus this
constexpr std::uint8_t kNotifyModemState = 7;

constexpr std::uint8_t kLineIdle = 0x60;     // transmit holding and shift register empty
constexpr std::uint8_t kModemReady = 0xB0;   // carrier detect, data set ready, clear to send
constexpr std::uint8_t kNoFlowControl = 1;   // outbound, or both ways
constexpr std::uint8_t kNoInboundFlow = 14;  // inbound

constexpr std::uint32_t kMinBaud = 50;  // the range of the rates that Linux names
constexpr std::uint32_t kMaxBaud = 4'000'000;

constexpr std::string_view kSignature = "virtdrive";

struct WireParity {
  std::uint8_t wire;
  Parity parity;
};
constexpr auto kParities =
    std::to_array<WireParity>({{1, Parity::kNone}, {2, Parity::kOdd}, {3, Parity::kEven}});

void append_escaped(std::vector<std::uint8_t>& wire, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) {
    wire.push_back(byte);
    if (byte == kIac) wire.push_back(kIac);
  }
}

}  // namespace

// A value is `size` bytes, the highest first; of a signature any size will do.
struct Rfc2217Session::Command {
  static constexpr std::size_t kAnySize = kMaxCommand;

  std::uint8_t code;
  std::size_t size;
  void (Rfc2217Session::*execute)(std::uint32_t value);
};

const Rfc2217Session::Command Rfc2217Session::kCommands[] = {
    {0, Command::kAnySize, &Rfc2217Session::signature},
    {1, 4, &Rfc2217Session::set_baud},
    {2, 1, &Rfc2217Session::set_data_bits},
    {3, 1, &Rfc2217Session::set_parity},
    {4, 1, &Rfc2217Session::set_stop_bits},
    {5, 1, &Rfc2217Session::control},
    {6, 0, &Rfc2217Session::line_state},  // 6 and 7 from a client: pyserial's poll_modem
    {kNotifyModemState, 0, &Rfc2217Session::modem_state},
    {8, 0, &Rfc2217Session::suspend},
    {9, 0, &Rfc2217Session::resume},
    {10, 1, &Rfc2217Session::line_state_mask},
    {11, 1, &Rfc2217Session::modem_state_mask},
    {12, 1, &Rfc2217Session::purge},
};

// COM-PORT is the client's to offer: pyserial 3.5, asked before it has offered, takes the request
// for an answer and never offers at all.
Rfc2217Session::Rfc2217Session(SerialLine& line, ClientOutbox& outbox)
    : line_(line),
      outbox_(outbox),
      options_({{kBinary, Agreed::kOffered, Agreed::kOffered},
                {kSuppressGoAhead, Agreed::kOffered, Agreed::kOffered},
                {kComPort, Agreed::kNo, Agreed::kNo}}) {
  for (const Option& option : options_) {
    if (option.ours == Agreed::kOffered) tell(kWill, option.code);
    if (option.theirs == Agreed::kOffered) tell(kDo, option.code);
  }
}

std::size_t Rfc2217Session::hear(std::span<const std::uint8_t> bytes) {
  ignored_ = 0;
  for (const std::uint8_t byte : bytes) hear(byte);
  send_data();
  return ignored_;
}

void Rfc2217Session::encode_pending() {
  if (suspended_) return;
  append_escaped(outbox_.wire, outbox_.pending);
  outbox_.pending.clear();
}

void Rfc2217Session::hear(std::uint8_t byte) {
  switch (state_) {
    case State::kData:
      if (byte == kIac) {
        state_ = State::kCommand;
      } else {
        data_.push_back(byte);
      }
      return;
    case State::kCommand:
      hear_command(byte);
      return;
    case State::kOption:
      state_ = State::kData;
      negotiate(verb_, byte);
      return;
    case State::kSub:
    case State::kSubCommand:
      hear_sub(byte);
      return;
  }
}

// What is neither data, a negotiation nor a subnegotiation (NOP, GA, AYT ...) means nothing here.
void Rfc2217Session::hear_command(std::uint8_t byte) {
  state_ = State::kData;
  if (byte == kIac) {
    data_.push_back(byte);
  } else if (byte == kSb) {
    sub_.clear();
    state_ = State::kSub;
  } else if (byte >= kWill) {
    verb_ = byte;
    state_ = State::kOption;
  }
}

void Rfc2217Session::hear_sub(std::uint8_t byte) {
  if (state_ == State::kSub && byte == kIac) {
    state_ = State::kSubCommand;
  } else if (state_ == State::kSub || byte == kIac) {
    state_ = State::kSub;
    if (sub_.size() <= kMaxCommand) sub_.push_back(byte);  // one more tells that it is too long
  } else if (byte == kSe) {
    state_ = State::kData;
    execute_sub();
  } else {  // cut off by another command
    ++ignored_;
    hear_command(byte);
  }
}

// What a client sent before a command leaves with the settings of then.
void Rfc2217Session::send_data() {
  if (!data_.empty()) line_.host_send(data_);
  data_.clear();
}

// RFC 1143: only a change is answered, or two ends could agree with each other for ever.
void Rfc2217Session::negotiate(std::uint8_t verb, std::uint8_t code) {
  const bool about_us = verb == kDo || verb == kDont;
  const bool yes = verb == kDo || verb == kWill;
  const std::uint8_t agree = about_us ? kWill : kDo;
  const std::uint8_t refuse = about_us ? kWont : kDont;
  const auto option = std::ranges::find(options_, code, &Option::code);
  if (option == options_.end()) {
    if (yes) tell(refuse, code);
    return;
  }
  Agreed& agreed = about_us ? option->ours : option->theirs;
  const Agreed before = agreed;
  agreed = yes ? Agreed::kYes : Agreed::kNo;
  if (yes && before == Agreed::kNo) tell(agree, code);
  if (!yes && before == Agreed::kYes) tell(refuse, code);
  const bool client_begins = yes && before != Agreed::kYes && code == kComPort && !about_us;
  if (client_begins) modem_state(0);
}

void Rfc2217Session::execute_sub() {
  if (sub_.size() < 2 || sub_.size() > kMaxCommand || sub_[0] != kComPort) {
    ++ignored_;
    return;
  }
  const std::span value = std::span(sub_).subspan(2);
  for (const Command& command : kCommands) {
    if (command.code != sub_[1]) continue;
    if (command.size != Command::kAnySize && command.size != value.size()) break;
    std::uint32_t number = 0;
    for (const std::uint8_t byte : value) number = number << 8 | byte;
    send_data();
    (this->*command.execute)(number);
    return;
  }
  ++ignored_;
}

void Rfc2217Session::tell(std::uint8_t verb, std::uint8_t option) {
  outbox_.wire.insert(outbox_.wire.end(), {kIac, verb, option});
}

void Rfc2217Session::answer(std::uint8_t code, std::span<const std::uint8_t> value) {
  outbox_.wire.insert(outbox_.wire.end(),
                      {kIac, kSb, kComPort, static_cast<std::uint8_t>(code + kServer)});
  append_escaped(outbox_.wire, value);
  outbox_.wire.insert(outbox_.wire.end(), {kIac, kSe});
}

void Rfc2217Session::answer(std::uint8_t code, std::uint8_t value) {
  answer(code, std::span(&value, 1));
}

// A client that tells its own signature wants no answer.
void Rfc2217Session::signature(std::uint32_t) {
  if (sub_.size() > 2) return;
  answer(0, std::vector<std::uint8_t>(kSignature.begin(), kSignature.end()));
}

void Rfc2217Session::set_baud(std::uint32_t baud) {
  HostSettings host = line_.host();
  if (baud >= kMinBaud && baud <= kMaxBaud) host.baud = static_cast<int>(baud);
  line_.set_host(host);
  const auto used = static_cast<std::uint32_t>(host.baud != 0 ? host.baud : line_.settings().baud);
  answer(1, std::to_array({static_cast<std::uint8_t>(used >> 24),
                           static_cast<std::uint8_t>(used >> 16),
                           static_cast<std::uint8_t>(used >> 8), static_cast<std::uint8_t>(used)}));
}

void Rfc2217Session::set_data_bits(std::uint32_t bits) {
  HostSettings host = line_.host();
  if (bits >= 5 && bits <= 8) host.data_bits = static_cast<int>(bits);
  line_.set_host(host);
  const int used = host.data_bits != 0 ? host.data_bits : line_.settings().data_bits;
  answer(2, static_cast<std::uint8_t>(used));
}

void Rfc2217Session::set_parity(std::uint32_t parity) {
  HostSettings host = line_.host();
  const auto asked = std::ranges::find(kParities, parity, &WireParity::wire);
  if (asked != kParities.end()) host.parity = asked->parity;
  line_.set_host(host);
  const Parity used = host.parity.value_or(line_.settings().parity);
  answer(3, std::ranges::find(kParities, used, &WireParity::parity)->wire);
}

void Rfc2217Session::set_stop_bits(std::uint32_t bits) {
  HostSettings host = line_.host();
  if (bits == 1 || bits == 2) host.stop_bits = static_cast<int>(bits);  // 3 would be one and a half
  line_.set_host(host);
  const int used = host.stop_bits != 0 ? host.stop_bits : line_.settings().stop_bits;
  answer(4, static_cast<std::uint8_t>(used));
}

// RFC 2217, section 3, SET-CONTROL.
void Rfc2217Session::control(std::uint32_t request) {
  struct Output {
    std::uint8_t ask, on, off;
    bool Rfc2217Session::* state;
  };
  constexpr auto kOutputs = std::to_array<Output>({{4, 5, 6, &Rfc2217Session::break_},
                                                   {7, 8, 9, &Rfc2217Session::dtr_},
                                                   {10, 11, 12, &Rfc2217Session::rts_}});
  for (const Output& output : kOutputs) {
    if (request < output.ask || request > output.off) continue;
    if (request != output.ask) this->*output.state = request == output.on;
    answer(5, this->*output.state ? output.on : output.off);
    return;
  }
  const bool inbound = (request >= 13 && request <= 16) || request == 18;
  const bool outbound = request <= 3 || request == 17 || request == 19;
  if (inbound) {
    answer(5, kNoInboundFlow);
  } else if (outbound) {
    answer(5, kNoFlowControl);
  } else {
    ++ignored_;
  }
}

void Rfc2217Session::line_state(std::uint32_t) {
  answer(6, line_.host_backlog() == 0 ? kLineIdle : std::uint8_t{0});
}

void Rfc2217Session::modem_state(std::uint32_t) {
  answer(kNotifyModemState, kModemReady & modem_state_mask_);
}

void Rfc2217Session::suspend(std::uint32_t) {
  suspended_ = true;
}

void Rfc2217Session::resume(std::uint32_t) {
  suspended_ = false;
}

void Rfc2217Session::line_state_mask(std::uint32_t mask) {
  line_state_mask_ = static_cast<std::uint8_t>(mask);
  answer(10, line_state_mask_);
}

void Rfc2217Session::modem_state_mask(std::uint32_t mask) {
  modem_state_mask_ = static_cast<std::uint8_t>(mask);
  answer(11, modem_state_mask_);
}

// What the client sent before has already begun to leave; only the way to the client is purged.
void Rfc2217Session::purge(std::uint32_t what) {
  if (what < 1 || what > 3) {
    ++ignored_;
    return;
  }
  if (what != 2) outbox_.pending.clear();
  answer(12, static_cast<std::uint8_t>(what));
}

}  // namespace virtdrive
