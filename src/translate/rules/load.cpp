#include <fstream>
#include <sstream>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include "extperfc/translate/plan.hpp"
#include "extperfc/translate/rules.hpp"

#include "translate/rules/rule_reader.hpp"

namespace extperfc::translate {

namespace {

constexpr std::size_t kMaxBytes = 1U << 20U;  // of one file

/// One file: what it says, and what is wrong with it.
struct Page {
  Problems problems;
  RuleFile content;
};

/// Takes a document's events and remembers where it began.
class DocumentStart : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& mark) override { line = mark.line + 1; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
  }
  void OnMapEnd() override {}

  int line{0};
};

/// 0 when there is none. YAML::LoadAll would report it too, but takes memory without end for some damaged
/// texts (yaml-cpp 0.7: ", a: &"), because it meets document after document without getting on.
int line_of_second_document(const std::string& text, Problems& problems) {
  std::istringstream in(text);
  YAML::Parser parser(in);
  DocumentStart first, second;
  try {
    if (!parser.HandleNextDocument(first) || !parser.HandleNextDocument(second)) return 0;
  } catch (const YAML::Exception& error) {
    problems.add(error.mark.is_null() ? 0 : error.mark.line + 1, "", "not YAML: " + error.msg,
                 ErrorCode::kCorrupt);
    return 0;
  }
  return second.line;
}

Page read_page(const std::string& text, const std::string& name, const DefinitionStore& definitions) {
  Page page{Problems(name), {}};
  if (text.size() > kMaxBytes) {
    page.problems.add(0, "", "is larger than " + std::to_string(kMaxBytes) + " bytes: divide it");
    return page;
  }
  const auto root = parse_yaml(text, page.problems);
  if (!root) return page;
  const int second = line_of_second_document(text, page.problems);
  if (second > 0) page.problems.add(second, "", "a second document begins: write one list of rules");
  page.content = RuleReader(definitions, page.problems).read(*root);
  return page;
}

Page read_file(const std::filesystem::path& path, const DefinitionStore& definitions) {
  const std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file && !std::filesystem::is_directory(path)) text << file.rdbuf();
  if (file && text) return read_page(text.str(), path.string(), definitions);
  Page page{Problems(path.string()), {}};
  page.problems.add(0, "", "cannot be read: check the path and its permissions");
  return page;
}

/// Adds what is sound; a pair that has a rule already is a problem.
void add_rules(Page& page, RuleSet& set) {
  for (const auto& [from, to] : page.content.renames) set.add_rename(from, to);
  for (Draft& draft : page.content.drafts) {
    if (!draft.sound) continue;
    if (const auto* other = set.find(*draft.from, *draft.to)) {
      page.problems.add(draft.line, draft.rule.from_type,
                        "a second rule for this pair of definitions; the first is at " + other->origin);
      draft.sound = false;
      continue;
    }
    set.add_schema(draft.from);
    set.add_schema(draft.to);
    set.add(draft.rule);
  }
}

/// A rule is good when the plan of its pair can be made: that finds types that do not convert.
void check_plans(Page& page, const RuleSet& set) {
  for (const Draft& draft : page.content.drafts) {
    if (!draft.sound) continue;
    const auto plan = Plan::compile(draft.from, draft.to, set);
    if (!plan) page.problems.add(draft.line, "", plan.error().message);
  }
}

Result<RuleSet> assemble(std::vector<Page> pages) {
  RuleSet set;
  for (Page& page : pages) add_rules(page, set);
  std::string message;
  for (Page& page : pages) {
    check_plans(page, set);
    for (const std::string& line : page.problems.lines()) message += (message.empty() ? "" : "\n") + line;
  }
  if (!message.empty()) return fail(ErrorCode::kInvalidArgument, message);
  return set;
}

}  // namespace

Result<RuleSet> load_rules(const std::vector<std::filesystem::path>& files,
                           const DefinitionStore& definitions) {
  std::vector<Page> pages;
  pages.reserve(files.size());
  for (const auto& file : files) pages.push_back(read_file(file, definitions));
  return assemble(std::move(pages));
}

Result<RuleSet> parse_rules(const std::string& text, const std::string& name,
                            const DefinitionStore& definitions) {
  std::vector<Page> pages;
  pages.push_back(read_page(text, name, definitions));
  return assemble(std::move(pages));
}

}  // namespace extperfc::translate
