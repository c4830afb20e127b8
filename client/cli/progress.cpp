// SPDX-License-Identifier: Apache-2.0
#include "client/cli/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "client/cli/output.h"
#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr auto kLineEvery = std::chrono::seconds(10);

std::string bar(double fraction) {
  constexpr int kCells = 16;
  const int full = static_cast<int>(std::lround(std::clamp(fraction, 0.0, 1.0) * kCells));
  char percent[16];
  std::snprintf(percent, sizeof percent, "] %2.0f %%", 100.0 * std::clamp(fraction, 0.0, 1.0));
  return "[" + std::string(static_cast<std::size_t>(full), '#') +
         std::string(static_cast<std::size_t>(kCells - full), '-') + percent;
}

std::string cut(const std::string& text, int width) {
  if (static_cast<int>(report::columns(text)) <= width) return text;
  std::string out;
  int used = 0;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xc0) != 0x80 && ++used > width) break;
    out += c;
  }
  return out;
}

}  // namespace

std::string job_line(const client::JobUpdate& update, int width) {
  std::string head =
      "job " + update.job_id + "  " + std::string(client::job_state_name(update.state));
  if (update.link == client::Link::lost) head += "  (server silent, waiting)";
  if (update.state != client::JobState::running)
    return cut(update.message.empty() ? head : head + "  " + report::printable(update.message),
               width);

  if (update.attempt > 1) head += "  attempt " + std::to_string(update.attempt);
  std::string stage =
      report::printable(update.stage + (update.detail.empty() ? "" : " " + update.detail));
  std::string solver;
  if (update.iteration > 0) {
    char numbers[80];
    std::snprintf(numbers, sizeof numbers, "iteration %lld  cost %.4g",
                  static_cast<long long>(update.iteration), update.cost);
    solver = numbers;
  }
  std::string times;
  if (update.elapsed_s > 0.0) {
    times = seconds_words(update.elapsed_s);
    if (update.fraction > 0.02 && update.fraction < 1.0 && update.elapsed_s > 1.0)
      times += ", about " +
               seconds_words(update.elapsed_s * (1.0 - update.fraction) / update.fraction) +
               " left";
  }
  std::string drawn = update.fraction >= 0.0 ? bar(update.fraction) : "";
  const auto line = [&] {
    std::string all = head;
    for (const std::string* part : {&stage, &solver, &drawn, &times})
      if (!part->empty()) all += "  " + *part;
    return all;
  };
  // on a narrow terminal what moves least goes first
  if (static_cast<int>(report::columns(line())) > width) stage = report::printable(update.stage);
  if (static_cast<int>(report::columns(line())) > width) solver.clear();
  return cut(line(), width);
}

ProgressDisplay::ProgressDisplay(std::ostream& out, bool terminal, int width)
    : out_(out), terminal_(terminal), width_(width) {}

ProgressDisplay::~ProgressDisplay() {
  finish();
}

void ProgressDisplay::show(const client::JobUpdate& update, Clock::time_point now) {
  // what is worth a line of its own where lines cannot be redrawn
  const std::string milestone = std::string(client::job_state_name(update.state)) + "/" +
                                std::to_string(update.attempt) + "/" + update.stage +
                                (update.link == client::Link::lost ? "/lost" : "");
  draw(job_line(update, terminal_ ? width_ - 1 : 400), milestone, now);
}

void ProgressDisplay::show_transfer(const std::string& what,
                                    const client::TransferProgress& progress,
                                    Clock::time_point now) {
  const double done = static_cast<double>(progress.bytes_done);
  const double total = static_cast<double>(progress.bytes_total);
  if (what != transfer_) {
    transfer_ = what;
    transfer_start_ = now;
    bytes_before_ = done;
    // a short transfer is not worth a line
    if (!terminal_) {
      last_milestone_ = "transfer/" + what;
      last_ = now;
    }
  }
  std::string line = what + "  " + bar(total > 0.0 ? done / total : 1.0) + "  " +
                     bytes_words(done) + " of " + bytes_words(total);
  if (progress.bytes_resumed > 0)
    line += ", " + bytes_words(static_cast<double>(progress.bytes_resumed)) + " were there";
  const double seconds = std::chrono::duration<double>(now - transfer_start_).count();
  if (seconds > 0.5 && done > bytes_before_)
    line += "  " + bytes_words((done - bytes_before_) / seconds) + "/s";
  std::string milestone = "transfer/" + what;
  if (progress.stored) {
    line = what + "  " + bytes_words(total) + " stored; the server reads them";
    if (terminal_) milestone += "/stored";
  }
  draw(cut(line, terminal_ ? width_ - 1 : 400), milestone, now);
}

void ProgressDisplay::draw(const std::string& line, const std::string& milestone,
                           Clock::time_point now) {
  const bool news = milestone != last_milestone_;
  if (!news && now - last_ < (terminal_ ? Clock::duration(kRedraw) : Clock::duration(kLineEvery)))
    return;
  last_ = now;
  last_milestone_ = milestone;
  if (terminal_) {
    out_ << "\r\x1b[K" << line << std::flush;
    drawn_ = true;
  } else {
    out_ << line << '\n' << std::flush;
  }
}

void ProgressDisplay::finish() {
  if (drawn_) out_ << "\r\x1b[K" << std::flush;
  drawn_ = false;
}

}  // namespace tenter::cli
