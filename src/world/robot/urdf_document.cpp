#include "world/robot/urdf_document.hpp"

#include <clocale>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

namespace extperfc {

namespace {

/// The calling thread's locale is "C" while this lives.
class CLocale {
 public:
  CLocale() : c_(newlocale(LC_ALL_MASK, "C", nullptr)), before_(uselocale(c_)) {}
  CLocale(const CLocale&) = delete;
  CLocale& operator=(const CLocale&) = delete;
  ~CLocale() {
    uselocale(before_);
    freelocale(c_);
  }

 private:
  locale_t c_;
  locale_t before_;
};

/// Keeps urdfdom's errors of the calling thread while this lives; other threads' messages pass through.
class Complaints : public console_bridge::OutputHandler {
 public:
  Complaints() : before_(console_bridge::getOutputHandler()) { console_bridge::useOutputHandler(this); }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  ~Complaints() override { console_bridge::useOutputHandler(before_); }

  void log(const std::string& text, console_bridge::LogLevel level, const char* file, int line) override {
    if (std::this_thread::get_id() != thread_) {
      if (before_ != nullptr) before_->log(text, level, file, line);
      return;
    }
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    text_ += (text_.empty() ? "" : "; ") + text;
  }

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  console_bridge::OutputHandler* before_;
  std::thread::id thread_{std::this_thread::get_id()};
  std::string text_;
};

/// The same model, whose links let go of each other at its end: urdfdom's links own their children, so a loop
/// of them would stay in memory.
urdf::ModelInterfaceSharedPtr without_ownership_loops(urdf::ModelInterfaceSharedPtr model) {
  urdf::ModelInterface* const raw = model.get();
  return {raw, [kept = std::move(model)](urdf::ModelInterface*) {
            for (const auto& entry : kept->links_) entry.second->child_links.clear();
          }};
}

}  // namespace

Result<urdf::ModelInterfaceSharedPtr> parse_urdf(const std::string& xml) {
  static std::mutex one_at_a_time;  // the output handler is one for the process
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  const CLocale c_locale;
  const Complaints complaints;
  urdf::ModelInterfaceSharedPtr model;
  std::string thrown;
  try {
    model = urdf::parseURDF(xml);
  } catch (const std::exception& e) {
    thrown = e.what();
  }
  if (model && complaints.text().empty()) return without_ownership_loops(std::move(model));
  const std::string& reason = thrown.empty() ? complaints.text() : thrown;
  return fail(ErrorCode::kCorrupt, "not a valid URDF: " + (reason.empty() ? "no <robot> element" : reason) +
                                       " (check_urdf shows details)");
}

}  // namespace extperfc
