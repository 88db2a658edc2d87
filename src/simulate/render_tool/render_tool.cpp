#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <unistd.h>

#include "extperfc/simulate/world_spec.hpp"

#include "simulate/render_tool/image_maker.hpp"
#include "simulate/render_tool/options.hpp"
#include "simulate/render_tool/sequence.hpp"
#include "simulate/render_tool/voc_folder.hpp"

using namespace extperfc;            // NOLINT: a program, not a header
using namespace extperfc::simulate;  // NOLINT

namespace {

constexpr int kProblem = 1;
constexpr int kUsage = 2;
constexpr int kInterrupted = 130;

std::atomic<bool> interrupted{false};  // NOLINT: set by the signal handler

int complain(const std::string& message, int status) {
  std::cerr << "extperfc-render: " << message
            << (status == kUsage ? " (--help lists the arguments)\n" : "\n");
  return status;
}

/// The first Ctrl-C ends in order, the second one at once.
void listen_for_interrupts() {
  struct sigaction action {};
  action.sa_handler = [](int) { interrupted = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

/// Work shared between threads: a world's images at a time.
class Job {
 public:
  Job(const Options& options, const VocFolder& folder, std::shared_ptr<const WorldSpec> world)
      : options_(options), folder_(folder), world_(std::move(world)) {}

  /// Runs to the end, to an interruption or to the first error.
  Result<void> run() {
    std::vector<std::thread> threads;
    const int cores = static_cast<int>(std::thread::hardware_concurrency());
    const int count = std::max(1, options_.threads > 0 ? options_.threads : cores);
    running_ = count;
    threads.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) threads.emplace_back([this] { work(); });
    show_progress();
    for (std::thread& thread : threads) thread.join();
    if (error_) return tl::unexpected(*error_);
    return {};
  }

  [[nodiscard]] int written() const { return written_; }

 private:
  void work() {
    ImageMaker maker(options_, world_);
    for (int first = next_.fetch_add(ImageMaker::kImagesPerWorld); first < options_.count && !ended();
         first = next_.fetch_add(ImageMaker::kImagesPerWorld))
      for (int number = first; number < std::min(first + ImageMaker::kImagesPerWorld, options_.count);
           ++number)
        if (!ended()) make(maker, number);
    const std::lock_guard<std::mutex> lock(mutex_);
    --running_;
    changed_.notify_all();
  }

  void make(ImageMaker& maker, int number) {
    if (folder_.has(number)) {
      ++kept_;
      return;
    }
    const auto image = maker.make(number);
    const auto written = image ? folder_.write(number, **image) : Result<void>(tl::unexpected(image.error()));
    if (written) {
      ++written_;
      return;
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!error_) error_ = written.error();
    failed_ = true;
  }

  [[nodiscard]] bool ended() const { return interrupted || failed_; }

  void show_progress() {
    const auto start = std::chrono::steady_clock::now();
    const bool terminal = isatty(STDERR_FILENO) != 0;
    std::unique_lock<std::mutex> lock(mutex_);
    const auto interval = std::chrono::milliseconds(terminal ? 500 : 5000);
    while (!changed_.wait_for(lock, interval, [this] { return running_ == 0; })) print_line(start, terminal);
    if (terminal) std::fputs("\r\033[K", stderr);
  }

  void print_line(std::chrono::steady_clock::time_point start, bool terminal) const {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const int done = kept_ + written_;
    const double rate = written_ / seconds;
    const int left = rate > 0 ? static_cast<int>((options_.count - done) / rate) : 0;
    std::fprintf(stderr, "%s%d of %d images, %.1f per second, %d:%02d left%s", terminal ? "\r\033[K" : "",
                 done, options_.count, rate, left / 60, left % 60, terminal ? "" : "\n");
  }

  const Options& options_;
  const VocFolder& folder_;
  std::shared_ptr<const WorldSpec> world_;
  std::atomic<int> next_{0};
  std::atomic<int> written_{0};
  std::atomic<int> kept_{0};
  std::atomic<bool> failed_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  int running_{0};              // guarded by mutex_
  std::optional<Error> error_;  // guarded by mutex_
};

int record(const Options& options) {
  std::error_code error;
  if (std::filesystem::exists(options.out, error) && !std::filesystem::is_empty(options.out, error))
    return complain(options.out.string() + " is not an empty folder: give a new one", kProblem);
  listen_for_interrupts();
  const auto written = write_sequence(options, [](int) { return !interrupted; });
  if (!written) return complain(written.error().message, kProblem);
  std::printf("%s: %d frames%s\n", options.out.c_str(), *written, interrupted ? "; interrupted" : "");
  return interrupted ? kInterrupted : 0;
}

int render(const Options& options) {
  std::shared_ptr<const WorldSpec> world;
  if (!options.world.empty()) {
    auto loaded = load_world(options.world);
    if (!loaded) return complain(loaded.error().message, kProblem);
    world = std::make_shared<const WorldSpec>(std::move(*loaded));
  }
  const auto folder = VocFolder::open(options);
  if (!folder) return complain(folder.error().message, kProblem);
  listen_for_interrupts();
  const auto start = std::chrono::steady_clock::now();
  Job job(options, *folder, world);
  const auto done = job.run();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto listed = folder->write_sets();
  if (!done) return complain(done.error().message, kProblem);
  if (!listed) return complain(listed.error().message, kProblem);
  std::printf("%s: %d images, %d of them new, in %.1f s (%.1f per second)%s\n", options.out.c_str(), *listed,
              job.written(), seconds, job.written() / seconds,
              interrupted ? "; interrupted: --resume goes on" : "");
  return interrupted ? kInterrupted : 0;
}

}  // namespace

int main(int argc, char** argv) {
  const auto options = parse_options({argv + 1, argv + argc});
  if (!options) return complain(options.error().message, kUsage);
  if (!options->help) return options->sequence ? record(*options) : render(*options);
  std::cout << kHelp;
  return 0;
}
