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

/// A job's line with or without the detail of its stage.
std::string whole_line(const client::JobUpdate& update, int width, bool with_detail);

bool has_room(const client::JobUpdate& update, int width) {
  return static_cast<int>(report::columns(whole_line(update, 1000000, true))) <= width;
}

}  // namespace

std::string job_line(const client::JobUpdate& update, int width) {
  return whole_line(update, width, has_room(update, width));
}

std::vector<std::string> detail_lines(const client::JobUpdate& update, int width) {
  std::vector<std::string> lines;
  if (update.state != client::JobState::running || update.detail.empty() || has_room(update, width))
    return lines;
  const std::string detail = report::printable(update.detail);
  std::string line = "   ";
  const auto end_line = [&] {
    if (lines.size() < kDetailLines) lines.push_back(cut(line, width));
    line = "   ";
  };
  for (std::size_t from = 0; from < detail.size();) {
    const std::size_t sign = detail.find_first_of(",;", from);
    const std::size_t to = sign == std::string::npos ? detail.size() : sign + 1;
    const std::string part = detail.substr(from, to - from);
    const bool is_first = line.size() == 3;
    if (!is_first && static_cast<int>(report::columns(line + part)) > width) end_line();
    line += part.front() == ' ' ? part : " " + part;
    from = to;
  }
  end_line();
  return lines;
}

namespace {

std::string whole_line(const client::JobUpdate& update, int width, bool with_detail) {
  std::string head =
      "job " + update.job_id + "  " + std::string(client::job_state_name(update.state));
  if (update.link == client::Link::lost) head += "  (server silent, waiting)";
  if (update.state != client::JobState::running)
    return cut(update.message.empty() ? head : head + "  " + report::printable(update.message),
               width);

  if (update.attempt > 1) head += "  attempt " + std::to_string(update.attempt);
  std::string stage = report::printable(
      update.stage + (with_detail && !update.detail.empty() ? " " + update.detail : ""));
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
  if (static_cast<int>(report::columns(line())) > width) solver.clear();
  return cut(line(), width);
}

}  // namespace

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
  const int width = terminal_ ? width_ - 1 : 600;
  draw(job_line(update, width),
       terminal_ ? detail_lines(update, width) : std::vector<std::string>{}, milestone, now);
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
  draw(cut(line, terminal_ ? width_ - 1 : 400), {}, milestone, now);
}

std::string ProgressDisplay::clearing() const {
  return below_ > 0 ? "\r\x1b[J" : "\r\x1b[K";
}

void ProgressDisplay::draw(const std::string& line, const std::vector<std::string>& below,
                           const std::string& milestone, Clock::time_point now) {
  const bool news = milestone != last_milestone_;
  if (!news && now - last_ < (terminal_ ? Clock::duration(kRedraw) : Clock::duration(kLineEvery)))
    return;
  last_ = now;
  last_milestone_ = milestone;
  if (terminal_) {
    out_ << clearing() << line;
    // the cursor goes back up, so that the next drawing begins where this one did
    for (const std::string& next : below) out_ << "\n\r" << next;
    if (!below.empty()) out_ << "\x1b[" << below.size() << 'A';
    out_ << std::flush;
    drawn_ = true;
    below_ = below.size();
  } else {
    out_ << line << '\n' << std::flush;
  }
}

void ProgressDisplay::finish() {
  if (drawn_) out_ << clearing() << std::flush;
  drawn_ = false;
  below_ = 0;
}

}  // namespace tenter::cli
