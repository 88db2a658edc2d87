#include <filesystem>
#include <iostream>
#include <set>
#include <string>

#include "extperfc/base/arguments.hpp"
#include "extperfc/base/atomic_file.hpp"

#include "translate/tool/command.hpp"
#include "translate/tool/sources.hpp"

namespace extperfc::translate {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExportHelp =
    R"(Writes a set of definitions as a tree of packages: DIR/<package>/msg/<Name>.msg, srv/, action/.

  extperfc-translate export SET DIR [--package NAME]... [--config DIR]

Messages that are derived from actions are not written, since generators derive them. With --package, only these packages.
)";

constexpr const char* kStoreHelp =
    R"(Writes a store of definitions: one file per definition, named by its MD5, and sets/<name>.txt.

  extperfc-translate store DIR --set NAME=TREE[:TREE...] [--set NAME=TREE...]... [--fallback SET]

Each set is read from trees of packages; the first tree with a type has precedence. Embedded types that the trees lack are
taken from --fallback, a set given before. Comments are removed.
)";

/// Writes the files of one set.
class Exporter {
 public:
  Exporter(const DefinitionStore& store, std::string set, fs::path folder,
           const std::vector<std::string>& packages)
      : store_(store),
        set_(std::move(set)),
        folder_(std::move(folder)),
        packages_(packages.begin(), packages.end()) {}

  Result<std::size_t> run() {
    const auto content = store_.content(set_);
    std::set<std::string> derived;
    for (const auto& type : content.actions) {
      const auto action = store_.action_of_set(set_, type);
      for (const auto& part :
           {"Goal", "Result", "Feedback", "ActionGoal", "ActionResult", "ActionFeedback", "Action"})
        derived.insert(type + part);
      if (auto done = put(type, "action", {action->goal, action->result, action->feedback}); !done)
        return tl::unexpected(done.error());
    }
    for (const auto& type : content.services) {
      const auto service = store_.service_of_set(set_, type);
      if (auto done = put(type, "srv", {service->request, service->response}); !done)
        return tl::unexpected(done.error());
    }
    for (const auto& type : content.messages)
      if (derived.count(type) == 0)
        if (auto done = put(type, "msg", {store_.message_of_set(set_, type)}); !done)
          return tl::unexpected(done.error());
    return written_;
  }

 private:
  Result<void> put(const std::string& type, const std::string& kind, const std::vector<SchemaPtr>& parts) {
    const auto slash = type.find('/');
    if (!packages_.empty() && packages_.count(type.substr(0, slash)) == 0) return {};
    std::string text;
    for (const auto& part : parts) text += (&part == &parts.front() ? "" : "---\n") + part->text();
    ++written_;
    return write_text_atomically(
        folder_ / type.substr(0, slash) / kind / (type.substr(slash + 1) + "." + kind), text);
  }

  const DefinitionStore& store_;
  std::string set_;
  fs::path folder_;
  std::set<std::string> packages_;
  std::size_t written_{0};
};

}  // namespace

Result<int> run_export(const Tokens& tokens) {
  const auto arguments = Arguments::read(tokens, {0, 2, {"--config", "--package"}, {"--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  if (arguments->has("--help")) {
    std::cout << kExportHelp;
    return kFine;
  }
  if (arguments->operands().size() != 2)
    return fail(ErrorCode::kInvalidArgument, "give a set and a folder: export SET DIR");
  const auto store = open_store(*arguments);
  if (!store) return tl::unexpected(store.error());
  const auto& set = arguments->operands()[0];
  if (auto known = check_set(*store, set); !known) return tl::unexpected(known.error());
  const auto written = Exporter(*store, set, arguments->operands()[1], arguments->all("--package")).run();
  if (!written) return tl::unexpected(written.error());
  if (*written == 0) return fail(ErrorCode::kNotFound, "the set " + set + " has none of these packages");
  std::cout << *written << " definitions of " << set << " in " << arguments->operands()[1] << "\n";
  return kFine;
}

Result<int> run_store(const Tokens& tokens) {
  const auto arguments = Arguments::read(tokens, {0, 1, {"--set", "--fallback"}, {"--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  if (arguments->has("--help")) {
    std::cout << kStoreHelp;
    return kFine;
  }
  const auto sets = arguments->all("--set");
  if (arguments->operands().empty() || sets.empty())
    return fail(ErrorCode::kInvalidArgument, "give a folder and the sets: store DIR --set NAME=TREE");
  DefinitionStore store;
  for (const auto& set : sets) {
    const auto equals = set.find('=');
    if (equals == std::string::npos || equals == 0)
      return fail(ErrorCode::kInvalidArgument, "--set must be like NAME=TREE, not " + set);
    const auto read = read_tree(store, set.substr(equals + 1), set.substr(0, equals),
                                arguments->last("--fallback").value_or(""));
    if (!read) return tl::unexpected(read.error());
  }
  if (auto written = store.write_store(arguments->operands()[0]); !written)
    return tl::unexpected(written.error());
  DefinitionStore again;
  const auto count = again.add_store(arguments->operands()[0]);
  if (!count) return tl::unexpected(count.error());
  std::cout << *count << " definitions, " << again.sets().size() << " sets in " << arguments->operands()[0]
            << "\n";
  return kFine;
}

}  // namespace extperfc::translate
