#include "devices/wire_log.h"

#include <fmt/format.h>

namespace virtdrive {

void WireLog::tell(WireEvent::Kind kind, std::span<const std::uint8_t> bytes,
                   std::string_view text) {
  switch (kind) {
    case WireEvent::Kind::kRequest:
      ++counters_.requests;
      break;
    case WireEvent::Kind::kReply:
      ++counters_.replies;
      break;
    case WireEvent::Kind::kBadFrame:
      ++counters_.bad_frames;
      break;
    case WireEvent::Kind::kLost:
      counters_.bytes_lost += bytes.size();
      break;
  }
  if (listener_) listener_({kind, loop_.now(), bytes, text});
}

void WireLog::note_use(std::string_view name, protocol::Support support) {
  if (!notes_ || support != protocol::Support::kStored || !noted_.insert(name).second) return;
  notes_(fmt::format("{} is stored, but nothing acts on it", name));
}

}  // namespace virtdrive
