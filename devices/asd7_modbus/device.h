// The drive of asd7 on a line where Modbus RTU is spoken: silence cuts what is heard into frames,
// on the virtual clock.
#pragma once

#include "devices/asd7/station.h"
#include "devices/asd7_modbus/codec.h"
#include "devices/protocol/frame_buffer.h"

namespace virtdrive::asd7_modbus {

class Device final : public SerialReceiver {
 public:
  explicit Device(asd7::Station& station);

  void receive(std::uint8_t byte) override;

 private:
  void frame_ended();
  void act(const Frame& frame);
  void write(const Frame& frame, std::uint16_t number, std::int64_t value);
  void refuse(const Frame& frame, Exception exception);
  void forget();

  asd7::Station& station_;
  protocol::FrameBuffer<kLongestFrame> buffer_;
  bool too_long_ = false;
  Wakeup silence_;
};

}  // namespace virtdrive::asd7_modbus
