#include "scenarios/scenario/probe_host.h"

#include "core/check.h"

namespace virtdrive {
namespace {

struct Said {};  // the words were good: bytes were about to leave

class DeadEnd final : public HostTransport {
 public:
  void write(std::span<const std::uint8_t>) override { throw Said{}; }
  std::optional<std::uint8_t> read(SimDuration) override { return std::nullopt; }
};

}  // namespace

void check_words(const Place& place, const BenchDrive& drive,
                 const std::function<void(HostClient&)>& say) {
  try {
    say(*drive.kind().make_host(std::make_unique<DeadEnd>()));
  } catch (const Said&) {
  } catch (const ClientError&) {
  } catch (const SetupError& error) {
    place.fail(error.what());
  }
}

}  // namespace virtdrive
