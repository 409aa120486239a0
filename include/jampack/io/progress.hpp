// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#if __has_include(<unistd.h>)
#include <sys/ioctl.h>
#include <unistd.h>
#endif

namespace jampack {

/// One line that says how far a run is: rewritten in place on a terminal, elsewhere a plain line now and
/// then. The clock touches what is shown, nothing else.
///
///   Progress progress;
///   progress.phase("compaction", 0.90);                        // ends when phi has reached 0.90
///   progress.show(phi, {{"phi", phi}, {"P/E*", p}, {"Z", z}});
///   progress.finish();
class Progress {
 public:
  struct Quantity {
    std::string_view name;
    double value;
  };

  /// seconds_between: how often a plain line is written at most (terminal: ten times a second).
  explicit Progress(std::FILE* stream = stderr, double seconds_between = 5)
      : stream_(stream), terminal_(is_terminal(stream)), interval_(terminal_ ? 0.1 : seconds_between) {}
  ~Progress() { finish(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Begins a phase that ends when the quantity passed first to show() reaches `end`, from below or above.
  void phase(std::string name, double end) {
    finish();
    phase_ = std::move(name);
    end_ = end;
    n_shown_ = n_called_ = 0;
  }

  void show(double reached, std::initializer_list<Quantity> quantities) {
    const auto now = Clock::now();
    if (n_called_++ == 0) {
      phase_start_ = now;
      start_ = reached;
    }
    line_ = phase_;
    for (const auto& [name, value] : quantities) {
      char text[96];
      std::snprintf(text, sizeof text, "  %.*s %.4g", static_cast<int>(name.size()), name.data(), value);
      line_ += text;
    }
    line_ += time_left(reached, seconds(now - phase_start_));
    pending_ = true;
    if (n_shown_ > 0 && seconds(now - last_) < interval_) return;
    print(now);
  }

  /// Shows the last state of the phase if it was held back, and ends the line.
  void finish() {
    if (pending_) print(Clock::now());
    if (terminal_ && n_shown_ > 0) std::fputc('\n', stream_);
    n_shown_ = 0;
  }

 private:
  using Clock = std::chrono::steady_clock;

  static bool is_terminal([[maybe_unused]] std::FILE* stream) {
#if __has_include(<unistd.h>)
    return isatty(fileno(stream)) != 0;
#else
    return false;
#endif
  }

  /// Columns that can be rewritten: a line that wraps cannot.
  int terminal_width() const {
#if __has_include(<unistd.h>)
    winsize size{};
    if (ioctl(fileno(stream_), TIOCGWINSZ, &size) == 0 && size.ws_col > 1) return size.ws_col - 1;
#endif
    return 79;
  }

  static double seconds(Clock::duration duration) {
    return std::chrono::duration<double>(duration).count();
  }

  /// As if what is left went at the mean pace of the phase so far; nothing before a hundredth is done.
  std::string time_left(double reached, double elapsed) const {
    const double done = end_ == start_ ? 1 : std::clamp((reached - start_) / (end_ - start_), 0.0, 1.0);
    if (!(done > 0.01)) return "";
    const auto left = static_cast<long>(elapsed * (1 - done) / done + 0.5);
    char text[48];
    if (left < 100)
      std::snprintf(text, sizeof text, "  left %ld s", left);
    else if (left < 6000)
      std::snprintf(text, sizeof text, "  left %ld min", (left + 30) / 60);
    else
      std::snprintf(text, sizeof text, "  left %.1f h", static_cast<double>(left) / 3600);
    return text;
  }

  void print(Clock::time_point now) {
    if (terminal_)
      std::fprintf(stream_, "\r%.*s\x1b[K", terminal_width(), line_.c_str());
    else
      std::fprintf(stream_, "%s\n", line_.c_str());
    std::fflush(stream_);
    last_ = now;
    ++n_shown_;
    pending_ = false;
  }

  std::FILE* stream_;
  bool terminal_;
  double interval_;
  std::string phase_;
  std::string line_;
  double start_ = 0;
  double end_ = 0;
  long n_shown_ = 0;
  long n_called_ = 0;
  bool pending_ = false;
  Clock::time_point phase_start_;
  Clock::time_point last_;
};

}  // namespace jampack
