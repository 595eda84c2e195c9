#include "scenarios/recording/sampler.h"

#include <utility>

#include "core/check.h"

namespace virtdrive {

Sampler::Sampler(EventLoop& loop, const Registry& registry, const std::vector<std::string>& signals,
                 SimDuration interval, Sink sink)
    : loop_(loop),
      interval_(interval),
      sink_(std::move(sink)),
      due_(loop.add(Phase::kRecord, [this] { sample(); })) {
  if (interval <= SimDuration{}) throw SetupError("--interval: must be above 0");
  for (const std::string& name : signals) signals_.push_back(&registry.signal(name));
  row_.resize(signals_.size());
  due_.at(loop.now());
}

void Sampler::sample() {
  for (std::size_t i = 0; i < signals_.size(); ++i) row_[i] = signals_[i]->read();
  due_.at(loop_.now() + interval_);
  sink_(loop_.now(), row_);
}

}  // namespace virtdrive
