// A drive on its line with the 7-Series' own protocol: frames in, frames out, around the register
// bank.
//
// Silence is an answer: to format errors, to other numbers, to broadcasts that another drive
// answers, to unknown commands in binary, to a reset, and while the CPU is starting.
#pragma once

#include <optional>

#include "devices/asd7/codec.h"
#include "devices/asd7/station.h"

namespace virtdrive::asd7 {

class Device final : public SerialReceiver {
 public:
  explicit Device(Station& station);

  void receive(std::uint8_t byte) override;

 private:
  void take(const Message& message);
  bool is_for_me(const Message& message) const;
  bool answers(const Message& message) const;
  void act(const Message& message);
  void act_on_master(const Message& message);
  void refuse(const Message& message, Error error);
  ReplyStyle style() const;
  void drop(std::string_view why);
  void forget();
  void speak_as_master();
  void schedule_master();

  Station& station_;
  Decoder decoder_{protocol::Direction::kRequest};
  Wakeup silence_;
  Wakeup master_;
};

}  // namespace virtdrive::asd7
