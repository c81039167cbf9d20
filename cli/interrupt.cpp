#include "cli/interrupt.hpp"

#include <unistd.h>

#include <csignal>
#include <initializer_list>

namespace isopach::cli {
namespace {

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free);

// GDAL aborts where it gets no memory. Nothing but a write and an end may be done here.
extern "C" void on_abort(int) {
  constexpr char line[] = "isopach: a library gave up, most likely for want of memory: crop or thin the input\n";
  (void)!::write(STDERR_FILENO, line, sizeof line - 1);
  _exit(1);
}

extern "C" void on_signal(int) { stop.store(true, std::memory_order_relaxed); }

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
  struct sigaction before {};
  sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);  // nohup has it ignored
  std::signal(SIGABRT, on_abort);
  // A pipe without a reader and a file that may grow no further are failures of a write, which clean up.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
}

void end_by_broken_pipe() {
  std::signal(SIGPIPE, SIG_DFL);
  raise(SIGPIPE);
}

const std::atomic<bool>& interrupted() { return stop; }

}  // namespace isopach::cli
