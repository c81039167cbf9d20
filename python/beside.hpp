// Work beside the interpreter: a verb runs in a thread of its own while Python's waits for it without the GIL, wakes
// every few hundredths of a second to ask for signals (Ctrl-C), and tells progress and warnings from there: no call
// into Python comes from elsewhere.
#pragma once
#include <nanobind/nanobind.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "cli/input_words.hpp"
#include "cli/session.hpp"
#include "isopach/base/context.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/option_key.hpp"

namespace isopach::python {

namespace nb = nanobind;

/// The texts of the library go to Python as bytes that may be no UTF-8 (names of files): as os.fsdecode reads them.
nb::str to_str(const std::string& text);
std::string to_string(const nb::bytes& bytes);

/// The exception isopach._core.Failure(exit_code, message), made by the module.
void make_failure_type(nb::module_& module);
[[noreturn]] void raise_failure(ExitCode code, const std::string& message);

/// Runs `work` in a thread of its own and waits for it. Signals are looked for, progress and warnings told, by this
/// one.
class Beside {
 public:
  Beside(nb::object progress, nb::object warn) : progress_(std::move(progress)), warn_(std::move(warn)) {}

  [[nodiscard]] const std::atomic<bool>& cancelled() const { return cancelled_; }
  [[nodiscard]] bool tells_progress() const { return !progress_.is_none(); }
  void step(std::string_view stage, double fraction) {  // of the worker
    const std::lock_guard lock(mutex_);
    if (!steps_.empty() && steps_.back().first == stage)
      steps_.back().second = fraction;
    else
      steps_.emplace_back(stage, fraction);
  }
  void hear(const std::string& warning) {  // of the worker
    const std::lock_guard lock(mutex_);
    warnings_.push_back(for_shell(warning));
  }

  template <class Work>
  void run(Work&& work) {
    std::exception_ptr failure;
    std::exception_ptr stopped;  // a Python exception: KeyboardInterrupt, or what a callback raised
    std::thread worker([&] {
      try {
        work();
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard lock(mutex_);
      done_ = true;
      wake_.notify_one();
    });
    while (!wait()) {
      try {
        if (!stopped && PyErr_CheckSignals() != 0) throw nb::python_error();
        if (!stopped) tell();
      } catch (...) {
        stopped = std::current_exception();
        cancelled_ = true;
      }
    }
    {
      nb::gil_scoped_release released;
      worker.join();
    }
    if (!stopped && !failure) tell();
    if (stopped) std::rethrow_exception(stopped);
    if (failure) std::rethrow_exception(failure);
  }

 private:
  bool wait() {
    nb::gil_scoped_release released;
    std::unique_lock lock(mutex_);
    return wake_.wait_for(lock, std::chrono::milliseconds(20), [&] { return done_; });
  }
  void tell() {
    std::vector<std::pair<std::string, double>> steps;
    std::vector<std::string> warnings;
    {
      const std::lock_guard lock(mutex_);
      steps.swap(steps_), warnings.swap(warnings_);
    }
    if (!progress_.is_none())
      for (const auto& [stage, fraction] : steps) progress_(to_str(stage), fraction);
    if (!warn_.is_none())
      for (const std::string& warning : warnings) warn_(to_str(warning));
  }

  nb::object progress_, warn_;
  std::atomic<bool> cancelled_{false};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool done_ = false;
  std::vector<std::pair<std::string, double>> steps_;
  std::vector<std::string> warnings_;
};

/// Runs `work` beside the interpreter, in a session; failures of the library come out as Failure, those of memory as
/// MemoryError.
template <class Work>
void run_in(cli::Session& session, Beside& beside, Work&& work) {
  session.shell = false;
  session.cancelled = &beside.cancelled();
  if (beside.tells_progress())
    session.progress = [&](std::string_view stage, double fraction) { beside.step(stage, fraction); };
  session.warn = [&](const std::string& warning) { beside.hear(warning); };
  ExitCode code = ExitCode::done;
  std::string message;
  beside.run([&] {
    const cli::SessionScope scope(session);
    try {
      work();
    } catch (const Error& error) {
      code = error.code();
      message = for_shell(error.what());
      if (code == ExitCode::input || code == ExitCode::no_overlap) message = cli::naming_a_scan(message);
    }
  });
  session.cancelled = nullptr, session.progress = nullptr, session.warn = nullptr;
  if (code != ExitCode::done) raise_failure(code, message);
}

/// Work that has no words.
template <class Work>
void compute(Work&& work) {
  cli::Session session;
  Beside beside{nb::none(), nb::none()};
  run_in(session, beside, [&] {
    Context context;
    context.cancelled = session.cancelled;
    work(context);
  });
}

}  // namespace isopach::python
