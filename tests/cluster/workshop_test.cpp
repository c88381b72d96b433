#include "orasp/cluster/workshop.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

namespace orasp {
namespace {

std::string fault_in(Workshop& workshop, const std::string& task) {
  try {
    return "no fault: " + workshop.make(task, {});
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

std::string do_task(const std::string& task, const std::stop_token& stop) {
  if (task == "pid") return std::to_string(getpid());
  if (task == "throw") throw std::runtime_error("no luck");
  if (task == "memory") throw std::bad_alloc();
  if (task == "kill") std::raise(SIGKILL);
  if (task == "crash") {
    std::signal(SIGSEGV, SIG_DFL);
    std::raise(SIGSEGV);
  }
  if (task == "exit") _exit(3);
  if (task == "wait") {
    while (!stop.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return "stopped";
  }
  return "made of " + task;
}

TEST(Workshop, EachPieceIsDoneInAProcessOfItsOwn) {
  Workshop workshop(do_task);
  EXPECT_EQ(workshop.make("", {}), "made of ");
  const std::string large(3'000'000, 'x');
  EXPECT_EQ(workshop.make(large, {}), "made of " + large);
  const std::string one = workshop.make("pid", {});
  EXPECT_NE(one, workshop.make("pid", {}));
  EXPECT_NE(one, std::to_string(getpid()));
}

TEST(Workshop, WhatFailsSaysHowAndTheNextPieceIsDone) {
  Workshop workshop(do_task);
  EXPECT_EQ(fault_in(workshop, "throw"), "no luck");
  EXPECT_EQ(fault_in(workshop, "memory"), "out of memory");
  EXPECT_EQ(fault_in(workshop, "kill"), "killed by signal 9 (Killed)");
  EXPECT_EQ(fault_in(workshop, "crash"), "killed by signal 11 (Segmentation fault)");
  EXPECT_EQ(fault_in(workshop, "exit"), "ended with exit code 3");
  EXPECT_EQ(fault_in(workshop, "this"), "no fault: made of this");
}

TEST(Workshop, AStopIsPassedOn) {
  Workshop workshop(do_task);
  for (int i = 0; i < 3; ++i) {
    std::stop_source source;
    std::thread later([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      source.request_stop();
    });
    EXPECT_EQ(workshop.make("wait", source.get_token()), "stopped");
    later.join();
    EXPECT_EQ(workshop.make("this", source.get_token()), "made of this");
  }
}

}  // namespace
}  // namespace orasp
