#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "slave/commands/program.h"

namespace palpate {
namespace {

constexpr int kToItsEnd = 7;

// Simulates a program that takes longer to end than allowed.
void EndSlowly(StopOnSignal* stop) {
  kill(getpid(), SIGTERM);
  while (!stop->token().stop_requested()) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  std::_Exit(kToItsEnd);
}

TEST(StopOnSignalTest, WhatTakesTooLongToEndIsEnded) {
  EXPECT_EXIT(
      {
        StopOnSignal stop;
        EndSlowly(&stop);
      },
      testing::ExitedWithCode(0), "");
  EXPECT_EXIT(
      {
        StopOnSignal stop;
        stop.ExpectAnswer();
        EndSlowly(&stop);
      },
      testing::ExitedWithCode(kFailed), "stopped before completion");
}

// On busy processors images of a recording wait for their compression.
TEST(StopOnSignalTest, ARecordingIsWrittenToItsEnd) {
  EXPECT_EXIT(
      {
        StopOnSignal stop;
        stop.LetRecordingEnd();
        EndSlowly(&stop);
      },
      testing::ExitedWithCode(kToItsEnd), "");
}

// A command ends as soon as it is done, also when its waiting thread sleeps already. Reference: a
// thread that waits for its stop token alone. The shortest of 21 ends counts: other programs make
// some of them longer, a thread that polls makes all of them longer.
TEST(StopOnSignalTest, ItEndsWithoutDelay) {
  using std::chrono::steady_clock;
  const auto shortest_end = [](const auto& begin) {
    std::vector<steady_clock::duration> times;
    for (int i = 0; i < 21; ++i) {
      auto waiting = begin();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      const auto end = steady_clock::now();
      waiting.reset();
      times.push_back(steady_clock::now() - end);
    }
    return std::ranges::min(times);
  };
  const auto reference = shortest_end([] {
    return std::make_unique<std::jthread>([](const std::stop_token& end) {
      std::mutex mutex;
      std::unique_lock lock(mutex);
      std::condition_variable_any never;
      never.wait(lock, end, [] { return false; });
    });
  });
  EXPECT_LT(shortest_end([] { return std::make_unique<StopOnSignal>(); }), 20 * reference);
}

// The master uses this signal, so a user may send it here by mistake.
TEST(StopOnSignalTest, AnEmergencyBeforeTheActionIsSetIsNotLost) {
  StopOnSignal stop;
  std::atomic<int> heard{0};
  kill(getpid(), SIGUSR1);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  stop.OnEmergency([&] { ++heard; });
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (heard == 0 && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_EQ(heard, 1);
  kill(getpid(), SIGUSR1);
  while (heard == 1 && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_EQ(heard, 2);
  EXPECT_FALSE(stop.token().stop_requested());
  stop.OnEmergency(nullptr);
}

}  // namespace
}  // namespace palpate
