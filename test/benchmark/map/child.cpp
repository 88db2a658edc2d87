#include "test/benchmark/map/child.hpp"

#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <sstream>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "test/support/temporary_folder.hpp"

namespace extperfc::benchmark {
namespace {

namespace fs = std::filesystem;

constexpr double kKibInMb = 1024 / 1e6;
constexpr std::size_t kMaxErrorText = 400;
constexpr int kNotStarted = 127;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// In the new process. Standard input is empty: programs of MRPT wait for a key after an error.
[[noreturn]] void become(const std::vector<char*>& arguments, int output, unsigned max_cpu_s) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  const rlimit limit{max_cpu_s, RLIM_INFINITY};
  if (max_cpu_s > 0) setrlimit(RLIMIT_CPU, &limit);
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  execvp(arguments.front(), arguments.data());
  _exit(kNotStarted);
}

std::string complaint(const std::vector<std::string>& tokens, int status, const fs::path& output) {
  const std::string how = WIFSIGNALED(status) ? "was ended by signal " + std::to_string(WTERMSIG(status))
                                              : "ended with " + std::to_string(WEXITSTATUS(status));
  const std::string said = text_of(output);
  return tokens.front() + " " + how + ": " +
         said.substr(said.size() > kMaxErrorText ? said.size() - kMaxErrorText : 0);
}

/// What wait4() reports.
Result<ChildRun> ended(const std::vector<std::string>& tokens, int status, const rusage& used,
                       const fs::path& output) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotStarted)
    return fail(ErrorCode::kNotFound, tokens.front() + " cannot be started; is it installed?");
  const bool out_of_cpu = WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU;
  if (!out_of_cpu && (!WIFEXITED(status) || WEXITSTATUS(status) != 0))
    return fail(ErrorCode::kFailed, complaint(tokens, status, output));
  return ChildRun{seconds_of(used.ru_utime) + seconds_of(used.ru_stime),
                  kKibInMb * static_cast<double>(used.ru_maxrss), out_of_cpu};
}

}  // namespace

double figure_of(const Figures& figures, const std::string& name) {
  const auto found = figures.find(name);
  return found == figures.end() ? std::nan("") : found->second;
}

Result<ChildRun> run_program(const std::vector<std::string>& tokens, const fs::path& output,
                             unsigned max_cpu_s) {
  const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return fail(ErrorCode::kFailed, output.string() + ": " + std::strerror(errno));
  std::vector<char*> arguments;
  for (const auto& token : tokens)
    arguments.push_back(const_cast<char*>(token.c_str()));  // NOLINT: exec's type
  arguments.push_back(nullptr);
  const pid_t pid = fork();
  if (pid == 0) become(arguments, file, max_cpu_s);
  close(file);
  if (pid < 0) return fail(ErrorCode::kFailed, "starting " + tokens.front() + ": " + std::strerror(errno));
  int status = 0;
  rusage used{};
  while (wait4(pid, &status, 0, &used) < 0)
    if (errno != EINTR) return fail(ErrorCode::kFailed, tokens.front() + ": " + std::strerror(errno));
  return ended(tokens, status, used, output);
}

Result<Figures> run_part(const std::vector<std::string>& tokens) {
  const TemporaryFolder folder;
  std::vector<std::string> all{fs::read_symlink("/proc/self/exe").string(), "--part"};
  all.insert(all.end(), tokens.begin(), tokens.end());
  const auto run = run_program(all, folder.path() / "output");
  if (!run) return tl::unexpected(run.error());
  std::ifstream in(folder.path() / "output");
  Figures figures;
  std::string name;
  for (double value = 0; in >> name >> value;) figures[name] = value;
  if (!in.eof()) return fail(ErrorCode::kFailed, "a part said '" + name + "' where figures belong");
  return figures;
}

fs::path beside_this_program(const std::string& name) {
  return fs::read_symlink("/proc/self/exe").parent_path() / name;
}

}  // namespace extperfc::benchmark
