#include "pty/wire_pair.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace virtdrive {
namespace {

WireByte as_said(const Talker::Character& c, int talker) {
  return {c.byte, c.begin, c.end, c.content == Talker::Content::kWrongParity, talker};
}

}  // namespace

// --- Talker --------------------------------------------------------------------------------------

void Talker::Queue::push(const Character& character) {
  if (head_ > 64 && head_ > characters_.size() / 2) {  // each character moves once at the most
    characters_.erase(characters_.begin(), begin());
    head_ = 0;
  }
  characters_.push_back(character);
}

void Talker::Queue::pop() {
  if (++head_ == characters_.size()) clear();
}

void Talker::Queue::clear() {
  characters_.clear();
  head_ = 0;
}

// A burst goes on while its characters follow each other without a gap at the same settings: each
// one's time is computed from the burst's start, so that no rounding adds up. After `baud`
// characters a burst has lasted a whole number of seconds, and starting anew is exact.
void Talker::say(std::uint8_t byte, Content content, const LineSettings& settings, SimTime now) {
  if (idle_ < now || settings != sender_ || burst_count_ >= settings.baud) {
    idle_ = burst_start_ = std::max(idle_, now);
    burst_count_ = 0;
    sender_ = settings;
  }
  if (queue_.size() == kMaxQueued) {
    ++dropped_;
    return;
  }
  const SimTime end = burst_start_ + settings.time_of(++burst_count_);
  queue_.push({idle_, end, settings, byte, content});
  idle_ = end;
}

void Talker::hold_low(SimDuration duration, const LineSettings& settings, SimTime now) {
  if (queue_.size() == kMaxQueued) {
    ++dropped_;
    return;
  }
  const SimTime begin = std::max(idle_, now);
  queue_.push({begin, begin + duration, settings, 0, Content::kBreak});
  idle_ = begin + duration;
  // A start bit needs an edge: the line is high for a bit time.
  pause(settings.time_of(1) / settings.character_bits(), now);
}

void Talker::pause(SimDuration duration, SimTime now) {
  idle_ = burst_start_ = std::max(idle_, now) + duration;
  burst_count_ = 0;
}

void Talker::let_go(SimTime now) {
  queue_.clear();
  idle_ = burst_start_ = now;
  burst_count_ = 0;
}

Talker::Drive Talker::drive(SimTime t) const {
  using Level = Drive::Level;
  if (cut_) return {};
  const auto current = std::ranges::find_if(queue_, [t](const auto& c) { return t < c.end; });
  if (current == queue_.end()) return {};
  const Character& c = *current;
  if (t < c.begin) return {Level::kReleased, c.begin};
  if (c.content == Content::kLost) return {Level::kReleased, c.end};
  if (c.content == Content::kBreak) return {Level::kLow, c.end};
  const int bits = c.settings.character_bits();
  const SimDuration length = c.end - c.begin;
  const auto start_of = [&](std::int64_t bit) { return c.begin + length * bit / bits; };
  std::int64_t bit = (t - c.begin) / (length / bits + SimDuration{1});
  while (start_of(bit + 1) <= t) ++bit;
  const std::uint16_t levels =
      character_levels(c.byte, c.settings, c.content == Content::kWrongParity);
  return {(levels >> bit & 1) != 0 ? Level::kHigh : Level::kLow, start_of(bit + 1)};
}

// --- WirePair: talking ---------------------------------------------------------------------------

WirePair::WirePair(EventLoop& loop, RandomStream& chance, LineCounters& counters)
    : loop_(loop),
      chance_(chance),
      counters_(counters),
      wakeup_(loop.add(Phase::kBytes, [this] { run(); })) {}

SimTime WirePair::send(Talker& talker, std::span<const std::uint8_t> bytes,
                       const LineSettings& settings, const LineFaults* faults) {
  if (begin(talker, settings)) counters_.garbled += bytes.size();
  for (const std::uint8_t byte : bytes) {
    if (faults == nullptr) {
      talker.say(byte, Talker::Content::kByte, settings, loop_.now());
    } else {
      utter(talker, byte, settings, *faults);
    }
  }
  return queued(talker);
}

SimTime WirePair::send_break(Talker& talker, SimDuration duration, const LineSettings& settings) {
  begin(talker, settings);
  sample_all();
  talker.hold_low(duration, settings, loop_.now());
  return queued(talker);
}

void WirePair::cut_off(Talker& talker) {
  if (talker.idle_ <= loop_.now()) return;
  sample_all();
  log_until(loop_.now());
  talker.let_go(loop_.now());
  look_again();
}

// What it means for those who listen that somebody is about to say more; true if one of them will
// not understand it.
bool WirePair::begin(Talker& talker, const LineSettings& settings) {
  if (talker.idle_ <= loop_.now()) {
    bool clash = false;
    bool collision = false;
    for (const Talker* other : active_) {
      if (other->idle_ <= loop_.now()) continue;
      clash = true;
      collision = collision || other != &noise_;
    }
    if (collision) ++counters_.collisions;
    if (clash || talker.cut_ || stuck_ != LineStuck::kNo) sample_all();
  }
  bool misunderstood = false;
  for (Listener* listener : listeners_) {
    if (!listener->on_ || listener->own_ == &talker) continue;
    if (understand_each_other(settings, listener->settings_)) continue;
    if (settings.timing == LineTiming::kReal) sample(*listener, in_flight_since());
    if (listener->kind_ == Listener::Kind::kEnd) misunderstood = true;
  }
  return misunderstood;
}

SimTime WirePair::queued(Talker& talker) {
  const SimTime out = std::max(talker.idle_, loop_.now());
  for (Listener* listener : listeners_) {
    if (listener->own_ == &talker && listener->sampling_) listener->uart_.listen_from(out);
  }
  const bool goes_on = talker.listed_ && sampling_ == 0;
  if (goes_on || talker.queue_.empty()) return out;
  if (!talker.listed_) active_.push_back(&talker);
  talker.listed_ = true;
  schedule();
  return out;
}

void WirePair::utter(Talker& talker, std::uint8_t byte, const LineSettings& settings,
                     const LineFaults& faults) {
  using Content = Talker::Content;
  if (happens(faults.delayed)) {
    ++counters_.fault_delayed;
    talker.pause(faults.delay, loop_.now());
  }
  if (happens(faults.lost)) {
    ++counters_.fault_lost;
    talker.say(byte, Content::kLost, settings, loop_.now());
    return;
  }
  Content content = Content::kByte;
  if (happens(faults.flipped)) {
    ++counters_.fault_flipped;
    const bool parity = settings.parity != Parity::kNone;
    const auto bit = chance_.bits() % static_cast<unsigned>(settings.data_bits + (parity ? 1 : 0));
    if (bit < static_cast<unsigned>(settings.data_bits)) {  // else the parity bit itself
      byte = static_cast<std::uint8_t>(byte ^ 1U << bit);
    }
    if (parity) content = Content::kWrongParity;
  }
  talker.say(byte, content, settings, loop_.now());
  if (happens(faults.duplicated)) {
    ++counters_.fault_duplicated;
    talker.say(byte, content, settings, loop_.now());
  }
}

// --- WirePair: listening -------------------------------------------------------------------------

void WirePair::switch_on(Listener& listener, const LineSettings& settings) {
  listener.on_ = true;
  listener.settings_ = settings;
  begin_anew(listener);
}

void WirePair::switch_off(Listener& listener) {
  listener.on_ = false;
  stop_sampling(listener);
}

void WirePair::tune(Listener& listener, const LineSettings& settings) {
  const bool same = understand_each_other(settings, listener.settings_);
  listener.settings_ = settings;
  if (listener.on_ && !same) begin_anew(listener);
}

// What is on the wires at this moment a receiver hears from its middle on.
void WirePair::begin_anew(Listener& listener) {
  if (!somebody_talks() && stuck_ != LineStuck::kLow) return;
  sample(listener, loop_.now());
  look_again();
}

void WirePair::run() {
  const SimTime now = loop_.now();
  if (sampling_ > 0) log_until(now);
  hear_directly();
  if (sampling_ > 0) hear_samples();
  if (now >= next_noise_) {
    draw_next_noise();
    if (!somebody_talks()) make_noise();
  }
  schedule();
}

void WirePair::hear_directly() {
  using Content = Talker::Content;
  bool fell_silent = false;
  for (std::size_t i = 0; i < active_.size(); ++i) {  // who hears may talk, and become active
    Talker& talker = *active_[i];
    while (!talker.queue_.empty() && talker.queue_.front().end <= loop_.now()) {
      const Talker::Character character = talker.queue_.front();
      talker.queue_.pop();
      if (character.content == Content::kLost || character.content == Content::kBreak) continue;
      if (character.begin < character.end) {
        hear_directly(talker, character);
      } else {
        if (!talker.cut_ && stuck_ == LineStuck::kNo) untimed_.push_back(character);
      }
    }
    if (!untimed_.empty()) hear_untimed(talker, std::exchange(untimed_, {}));
    fell_silent = fell_silent || talker.queue_.empty();
  }
  if (!fell_silent) return;
  std::erase_if(active_, [](Talker* talker) {
    talker->listed_ = !talker->queue_.empty();
    return !talker->listed_;
  });
}

void WirePair::hear_directly(const Talker& talker, const Talker::Character& c) {
  const WireByte byte = as_said(c, talker.id_);
  for (std::size_t i = 0; i < listeners_.size(); ++i) {
    Listener& listener = *listeners_[i];
    const bool hears = listener.on_ && listener.own_ != &talker && c.end <= listener.direct_until_;
    if (hears) listener.hear_(byte);
  }
}

// An ideal line leaves no time in which to sample. Who is set otherwise hears what a burst would be
// at real speed, all at once.
void WirePair::hear_untimed(const Talker& talker, std::vector<Talker::Character> said) {
  const LineSettings settings = said.front().settings;
  const auto changed = std::ranges::find_if(
      said, [&](const Talker::Character& c) { return c.settings != settings; });
  const std::vector<Talker::Character> later(changed, said.end());
  said.erase(changed, said.end());
  std::vector<std::uint8_t> bytes;
  for (const Talker::Character& character : said) bytes.push_back(character.byte);
  for (std::size_t i = 0; i < listeners_.size(); ++i) {
    Listener& listener = *listeners_[i];
    if (!listener.on_ || listener.own_ == &talker) continue;
    if (understand_each_other(settings, listener.settings_)) {
      for (const Talker::Character& character : said) {
        if (listener.on_) listener.hear_(as_said(character, talker.id_));
      }
      continue;
    }
    for (WireByte byte : resample(bytes, settings, listener.settings_)) {
      byte.begin = byte.end = loop_.now();
      byte.talker = talker.id_;
      if (listener.on_) listener.hear_(byte);
    }
  }
  if (!later.empty()) hear_untimed(talker, later);
}

void WirePair::hear_samples() {
  for (std::size_t i = 0; i < listeners_.size(); ++i) {
    Listener& listener = *listeners_[i];
    while (listener.sampling_) {
      std::optional<WireByte> byte =
          listener.uart_.read(levels_, listener.settings_, std::min(logged_, loop_.now()));
      if (!byte) break;
      byte->collided = byte->begin < clash_end_ && byte->end > clash_begin_;
      listener.hear_(*byte);
    }
  }
  SimTime needed = std::min(logged_, in_flight_since());
  for (const Listener* listener : listeners_) {
    if (listener->sampling_) needed = std::min(needed, listener->uart_.from());
  }
  levels_.forget_before(needed);
  settle();
}

// --- WirePair: sampling --------------------------------------------------------------------------

bool WirePair::somebody_talks() const {
  return std::ranges::any_of(active_, [](const Talker* t) { return !t->queue_.empty(); });
}

/// The begin of the earliest character that is on the wires now.
SimTime WirePair::in_flight_since() const {
  SimTime since = loop_.now();
  for (const Talker* talker : active_) {
    for (const Talker::Character& character : talker->queue_) {
      if (character.end <= loop_.now()) continue;  // heard at this very instant
      since = std::min(since, character.begin);
      break;
    }
  }
  return since;
}

void WirePair::sample_all() {
  const SimTime since = in_flight_since();
  for (Listener* listener : listeners_) {
    if (!listener->sampling_) sample(*listener, since);
  }
}

void WirePair::sample(Listener& listener, SimTime from) {
  if (!listener.on_) return;
  if (sampling_ == 0) {
    levels_.clear();
    logged_ = in_flight_since();
    levels_.append(logged_, stuck_ != LineStuck::kLow);
  }
  if (!listener.sampling_) {
    ++sampling_;
    listener.sampling_ = true;
    listener.direct_until_ = from;
  }
  const bool deaf = listener.own_ != nullptr && listener.own_->idle_ > from;
  listener.uart_.listen_from(deaf ? listener.own_->idle_ : from);
}

void WirePair::stop_sampling(Listener& listener) {
  if (!listener.sampling_) return;
  --sampling_;
  listener.sampling_ = false;
  listener.direct_until_ = kNever;
}

void WirePair::log_until(SimTime t) {
  while (logged_ < t) {
    SimTime next = t;
    int low = 0;
    int high = 0;
    int pulls = kNoTalker;
    for (const Talker* talker : active_) {
      const Talker::Drive drive = talker->drive(logged_);
      next = std::min(next, drive.until);
      if (drive.level == Talker::Drive::Level::kHigh) ++high;
      if (drive.level == Talker::Drive::Level::kLow) {
        ++low;
        pulls = talker->id();
      }
    }
    bool level = low == high ? low == 0 || chance_.bits() >> 63 != 0 : high > low;
    if (stuck_ != LineStuck::kNo) level = stuck_ == LineStuck::kHigh;
    if (low + high > 1) {
      if (clash_end_ != logged_) clash_begin_ = logged_;
      clash_end_ = next;
    }
    levels_.append(logged_, level, pulls);
    logged_ = next;
  }
}

// Back to the simple way once everybody is between two characters.
void WirePair::settle() {
  if (somebody_talks() || !levels_.high()) return;
  for (const Listener* listener : listeners_) {
    if (!listener->sampling_) continue;
    if (listener->uart_.due(levels_, listener->settings_) != kNever) return;
  }
  for (Listener* listener : listeners_) stop_sampling(*listener);
}

void WirePair::schedule() {
  SimTime next = next_noise_;
  bool more = false;
  for (const Talker* talker : active_) {
    if (talker->queue_.empty()) continue;
    next = std::min(next, talker->queue_.front().end);
    more = true;
  }
  if (sampling_ > 0) {
    for (const Listener* listener : listeners_) {
      if (!listener->sampling_) continue;
      // An edge that is not known yet is not before the end of what is logged.
      SimTime due = listener->uart_.due(levels_, listener->settings_);
      if (due == kNever && more) due = logged_ + reading_time(listener->settings_);
      next = std::min(next, std::max(due, loop_.now()));
    }
  }
  wakeup_.at(next);
}

void WirePair::look_again() {
  wakeup_.at(loop_.now());
}

// --- WirePair: faults ----------------------------------------------------------------------------

void WirePair::hold(LineStuck level) {
  if (level == stuck_) return;
  sample_all();
  log_until(loop_.now());
  stuck_ = level;
  if (!somebody_talks()) levels_.append(loop_.now(), level != LineStuck::kLow);
  look_again();
}

void WirePair::cut(Talker& talker, bool is_cut) {
  if (talker.cut_ == is_cut) return;
  if (talker.idle_ > loop_.now()) {
    sample_all();
    log_until(loop_.now());
    look_again();
  }
  talker.cut_ = is_cut;
}

void WirePair::make_noise() {
  ++counters_.noise;
  begin(noise_, noise_settings_);
  noise_.say(static_cast<std::uint8_t>(chance_.bits() >> 56), Talker::Content::kByte,
             noise_settings_, loop_.now());
  queued(noise_);
}

void WirePair::set_noise(double per_s, const LineSettings& settings) {
  noise_settings_ = settings;
  if (per_s == noise_per_s_) return;
  noise_per_s_ = per_s;
  draw_next_noise();
  look_again();
}

// Independent events: the gaps between them are distributed exponentially.
void WirePair::draw_next_noise() {
  next_noise_ = noise_per_s_ == 0
                    ? kNever
                    : loop_.now() + from_seconds(-std::log1p(-chance_.uniform()) / noise_per_s_);
}

}  // namespace virtdrive
