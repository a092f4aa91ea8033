#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "slave/commands/program.h"

namespace palpate {
namespace {

constexpr int kToItsEnd = 7;

// What a program does that takes longer to end than it may.
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

// A recording's pictures wait to be packed where processors are busy.
TEST(StopOnSignalTest, ARecordingIsWrittenToItsEnd) {
  EXPECT_EXIT(
      {
        StopOnSignal stop;
        stop.LetRecordingEnd();
        EndSlowly(&stop);
      },
      testing::ExitedWithCode(kToItsEnd), "");
}

// As it is the master's, somebody may well send it here.
TEST(StopOnSignalTest, ItsEmergencyIsHeardAlsoBeforeAnybodyListens) {
  StopOnSignal stop;
  std::atomic<int> heard{0};
  kill(getpid(), SIGUSR1);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  stop.OnEmergency([&] { ++heard; });
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (heard == 0 && std::chrono::steady_clock::now() < patience) std::this_thread::yield();
  EXPECT_EQ(heard, 1);
  kill(getpid(), SIGUSR1);
  while (heard == 1 && std::chrono::steady_clock::now() < patience) std::this_thread::yield();
  EXPECT_EQ(heard, 2);
  EXPECT_FALSE(stop.token().stop_requested());
  stop.OnEmergency(nullptr);
}

}  // namespace
}  // namespace palpate
