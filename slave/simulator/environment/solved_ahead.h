// Solves contacts in advance: a separate thread advances the requested contact step by step, so
// that a tool only reads finished solutions.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace palpate::simulation {

// The shared part of a contact. Guarded by the lock of SolvedAhead.
struct ContactAhead {
  bool begun = false;
  bool complete = false;  // no further step follows
};

// `Contact`: a ContactAhead with
//   Step Solve() noexcept   its next step; in the thread, without the lock
//   void Add(Step)          takes that step; with the lock held
template <typename Contact>
class SolvedAhead {
 public:
  // Returns the contact for the thread to work on; nullptr: none. Called in the thread, with the
  // lock held.
  using Choice = std::function<std::shared_ptr<Contact>()>;

  explicit SolvedAhead(Choice choice)
      : choice_(std::move(choice)), thread_([this](const std::stop_token& stop) { Run(stop); }) {}
  // Works on the newest request and stores up to this number of contacts.
  explicit SolvedAhead(std::size_t kept)
      : kept_(kept),
        choice_([this] {
          return wishes_.empty() || wishes_.front()->complete ? nullptr : wishes_.front();
        }),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  // Requests the contact for which `is_wanted` holds, or else a new one by `make`. It replaces a
  // previous request that was not started yet.
  template <typename Condition, typename Make>
  std::shared_ptr<Contact> Want(const Condition& is_wanted, const Make& make) {
    const std::lock_guard lock(mutex_);
    const auto known = std::ranges::find_if(wishes_, [&](const auto& w) { return is_wanted(*w); });
    const std::shared_ptr<Contact> contact = known == wishes_.end() ? make() : *known;
    if (known != wishes_.end()) wishes_.erase(known);
    if (!wishes_.empty() && !wishes_.front()->begun) wishes_.pop_front();
    wishes_.push_front(contact);
    if (wishes_.size() > kept_) wishes_.pop_back();
    changed_.notify_all();
    return contact;
  }
  // For WhenUnsolved::kWait: returns the result of `read` as soon as `is_enough`.
  template <typename Condition, typename Read>
  auto Await(const Condition& is_enough, const Read& read) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, is_enough);
    return read();
  }
  // For WhenUnsolved::kUseNearest: returns the present result of `read`.
  template <typename Read>
  auto Now(const Read& read) {
    const std::lock_guard lock(mutex_);
    return read();
  }
  // Returns the present result of `read` for all contacts, newest first.
  template <typename Read>
  auto NowOfAll(const Read& read) {
    const std::lock_guard lock(mutex_);
    return read(std::as_const(wishes_));
  }
  // Runs `edit`, which changes the inputs of the choice.
  template <typename Edit>
  void Change(const Edit& edit) {
    const std::lock_guard lock(mutex_);
    edit();
    changed_.notify_all();
  }

 private:
  void Run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [this] { return choice_() != nullptr; })) {
      if (stop.stop_requested()) return;
      const std::shared_ptr<Contact> contact = choice_();
      contact->begun = true;
      lock.unlock();
      auto step = contact->Solve();
      lock.lock();
      contact->Add(std::move(step));
      changed_.notify_all();
    }
  }

  std::mutex mutex_;  // guards the members below, and the contacts
  std::condition_variable_any changed_;
  std::deque<std::shared_ptr<Contact>> wishes_;  // newest first
  std::size_t kept_ = 0;
  Choice choice_;
  std::jthread thread_;  // last: it uses everything above
};

}  // namespace palpate::simulation
