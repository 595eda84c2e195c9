#include "core/event_loop.h"

#include <utility>

#include "core/check.h"

namespace virtdrive {

Wakeup::Wakeup(Wakeup&& other) noexcept
    : loop_(std::exchange(other.loop_, nullptr)), slot_(other.slot_) {}

Wakeup& Wakeup::operator=(Wakeup&& other) noexcept {
  std::swap(loop_, other.loop_);
  std::swap(slot_, other.slot_);
  return *this;
}

Wakeup::~Wakeup() {
  if (loop_ != nullptr) loop_->remove(slot_);
}

void Wakeup::at(SimTime t) {
  VIRTDRIVE_CHECK(loop_ != nullptr, "a wake-up that was never registered");
  loop_->set(slot_, t);
}

void Wakeup::cancel() {
  if (loop_ != nullptr) loop_->set(slot_, kNever);
}

SimTime Wakeup::due() const {
  return loop_ == nullptr ? kNever : loop_->slots_[slot_].due;
}

Wakeup EventLoop::add(Phase phase, Callback callback) {
  std::size_t slot = 0;
  while (slot < slots_.size() && (slots_[slot].used || slot == running_)) ++slot;
  if (slot == slots_.size()) {
    slots_.emplace_back();
    heap_.push_back(slot);
    slots_[slot].heap_index = static_cast<std::uint32_t>(slot);
  }
  const std::uint32_t heap_index = slots_[slot].heap_index;
  slots_[slot] = {kNever, phase, registered_++, heap_index, true, std::move(callback)};
  sift(heap_index);
  return Wakeup{this, slot};
}

SimTime EventLoop::next() const {
  return heap_.empty() ? kNever : slots_[heap_.front()].due;
}

SimTime EventLoop::next(Phase last) const {
  SimTime earliest = kNever;
  for (const Slot& slot : slots_) {
    if (slot.phase <= last && slot.due < earliest) earliest = slot.due;
  }
  return earliest;
}

void EventLoop::run_until(SimTime t) {
  stopped_ = false;
  while (!stopped_ && next() <= t && next() != kNever) run_next();
  if (!stopped_ && now_ < t) now_ = t;
}

void EventLoop::run_before(SimTime t) {
  stopped_ = false;
  while (!stopped_ && next() < t) run_next();
  if (!stopped_ && now_ < t) now_ = t;
}

bool EventLoop::run_until(SimTime t, const std::function<bool()>& condition) {
  if (condition()) return true;
  while (next() <= t && next() != kNever) {
    const SimTime instant = next();
    run_until(instant);
    if (stopped_) return false;
    if (condition()) return true;
  }
  if (now_ < t) now_ = t;
  return condition();
}

bool EventLoop::before(std::size_t a, std::size_t b) const {
  const Slot& x = slots_[a];
  const Slot& y = slots_[b];
  if (x.due != y.due) return x.due < y.due;
  if (x.phase != y.phase) return x.phase < y.phase;
  return x.order < y.order;
}

void EventLoop::set(std::size_t slot, SimTime t) {
  VIRTDRIVE_CHECK(t >= now_, "a wake-up in the past: {} ns, now {} ns",
                  t.time_since_epoch().count(), now_.time_since_epoch().count());
  slots_[slot].due = t;
  sift(slots_[slot].heap_index);
}

void EventLoop::remove(std::size_t slot) {
  slots_[slot].due = kNever;
  slots_[slot].used = false;  // its callback may be the one running: it is replaced by the next add
  sift(slots_[slot].heap_index);
}

void EventLoop::place(std::size_t heap_index, std::size_t slot) {
  heap_[heap_index] = slot;
  slots_[slot].heap_index = static_cast<std::uint32_t>(heap_index);
}

void EventLoop::sift(std::size_t i) {
  const std::size_t slot = heap_[i];
  while (i > 0 && before(slot, heap_[(i - 1) / 2])) {
    place(i, heap_[(i - 1) / 2]);
    i = (i - 1) / 2;
  }
  for (std::size_t child = 2 * i + 1; child < heap_.size(); child = 2 * i + 1) {
    if (child + 1 < heap_.size() && before(heap_[child + 1], heap_[child])) ++child;
    if (!before(heap_[child], slot)) break;
    place(i, heap_[child]);
    i = child;
  }
  place(i, slot);
}

void EventLoop::run_next() {
  const std::size_t slot = heap_.front();
  now_ = slots_[slot].due;
  slots_[slot].due = kNever;
  sift(0);
  ++events_;
  running_ = slot;
  slots_[slot].callback();
  running_ = kNone;
}

}  // namespace virtdrive
