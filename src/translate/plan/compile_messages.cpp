#include <algorithm>
#include <functional>
#include <utility>

#include "translate/plan/compiler.hpp"

namespace extperfc::translate::plan {

namespace {

/// Which fields of the source a rule's source reads by path, below `index_of`.
void collect_roots(const Source& source, const MessageSchema& from, std::vector<bool>& roots) {
  const auto add = [&](const Path& path) {
    for (std::size_t i = 0; !path.empty() && i < from.fields().size(); ++i)
      if (from.fields()[i].name == path.front().field) roots[i] = true;
  };
  if (source.kind == Source::Kind::kField) {
    add(source.path);
    add(source.relative_to);
  }
  for (const auto& item : source.list) collect_roots(item, from, roots);
  for (const auto& [name, inner] : source.fields) collect_roots(inner, from, roots);
}

const Source* rule_of(const MigrationRule* rule, const std::string& field_name) {
  if (rule == nullptr) return nullptr;
  for (const auto& [name, source] : rule->targets)
    if (name == field_name) return &source;
  return nullptr;
}

std::optional<std::size_t> index_of(const MessageSchema& schema, const std::string& name) {
  const auto& fields = schema.fields();
  const auto found =
      std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
  if (found == fields.end()) return std::nullopt;
  return static_cast<std::size_t>(found - fields.begin());
}

std::string conversion_text(const Field& from, const Field& to, const PlanOptions& options) {
  if (from.primitive == Primitive::kTime && options.shift_times) return "shifted to the other clock";
  if (from.primitive == Primitive::kString && options.frame_slash != PlanOptions::Slash::kKeep &&
      to.primitive == Primitive::kString)
    return options.frame_slash == PlanOptions::Slash::kAdd ? "with a leading slash"
                                                           : "without leading slashes";
  auto before = to_string(from);
  auto after = to_string(to);
  before.resize(before.size() - from.name.size() - 1);
  after.resize(after.size() - to.name.size() - 1);
  return before == after ? "by its fields" : "from " + before + " to " + after;
}

}  // namespace

Result<Code> Compiler::compile(const MessageSchema& from, const MessageSchema& to,
                               const MigrationRule* rule) {
  Pair pair{from, to, rule, ""};
  if (auto done = message(pair); !done) return tl::unexpected(done.error());
  if (out_.overflowed())
    return fail(ErrorCode::kUnsupported, "the definitions are too large: their fixed parts exceed 4 GiB");
  auto& code = out_.code();
  code.growth = to.min_size() > from.min_size() ? to.min_size() - from.min_size() : 0;
  return std::move(code);
}

Result<void> Compiler::spend() {
  if (budget_.fields == 0)
    return fail(ErrorCode::kUnsupported, "the definitions are too large: they embed too many fields");
  --budget_.fields;
  return {};
}

void Compiler::note(NoteKind kind, const std::string& path, std::string text) {
  if (!quiet_) notes_.push_back({kind, path, std::move(text)});
}

Result<void> Compiler::embedded(const SchemaPtr& from, const SchemaPtr& to, const std::string& path) {
  if (budget_.depth == 0)
    return fail(ErrorCode::kUnsupported, "field " + path + " is embedded too deeply, or rules form a cycle");
  --budget_.depth;
  const bool same = from->type() == to->type() && from->md5() == to->md5();
  const auto* rule = same ? nullptr : rules_.find(*from, *to);
  std::vector<RuleSet::Link> links;
  if (!same && rule == nullptr) links = rules_.chain(from, to);
  Result<void> done;
  if (links.empty()) {
    Pair pair{*from, *to, rule, path + "."};
    done = message(pair);
  } else {
    done = chain(links, from, path);
  }
  ++budget_.depth;
  return done;
}

std::vector<Compiler::Piece> Compiler::pieces(const Pair& pair) const {
  std::vector<Piece> all;
  std::size_t beyond = 0;  // the last one read so far
  for (const auto& target : pair.to.fields()) {
    Piece one;
    one.target = &target;
    one.rule = rule_of(pair.rule, target.name);
    const bool by_field = one.rule == nullptr || is_whole_field(*one.rule);
    const auto& name = one.rule != nullptr && by_field ? one.rule->path.front().field : target.name;
    const auto index = by_field ? index_of(pair.from, name) : std::nullopt;
    if (index) {
      one.source = &pair.from.fields()[*index];
      one.source_index = *index;
      one.moved = *index < beyond;
      beyond = std::max(beyond, *index + 1);
    }
    all.push_back(one);
  }
  return all;
}

Result<void> Compiler::message(Pair& pair) {
  const auto all = pieces(pair);
  bool in_order = true;
  std::optional<std::size_t> last;
  for (const auto& one : all) {
    if (one.source == nullptr) {
      in_order = in_order && (one.rule == nullptr || one.rule->kind == Source::Kind::kValue);
      continue;
    }
    in_order = in_order && (!last || one.source_index > *last);
    last = one.source_index;
  }
  auto done = in_order ? streamed(pair, all) : scanned(pair, all);
  if (done) note_dropped(pair, all);
  return done;
}

void Compiler::drop(const Pair& pair, std::size_t first, std::size_t last) {
  if (first >= last) return;
  const auto& fields = pair.from.fields();
  out_.flush(pair.path + fields[first].name);
  for (std::size_t i = first; i < last; ++i) skip(fields[i], pair.path + fields[i].name);
  out_.anchor(pair.path + fields[last - 1].name);
}

Result<void> Compiler::streamed(Pair& pair, const std::vector<Piece>& all) {
  std::size_t next = 0;
  for (const auto& one : all) {
    if (one.source != nullptr) {
      drop(pair, next, one.source_index);
      next = one.source_index + 1;
    }
    if (auto done = piece(pair, one); !done) return done;
  }
  drop(pair, next, pair.from.fields().size());
  return {};
}

Result<void> Compiler::scanned(Pair& pair, const std::vector<Piece>& all) {
  const auto& fields = pair.from.fields();
  std::vector<bool> marked(fields.size(), false);
  std::vector<bool> seeks;  // by piece
  const auto nowhere = fields.size() + 1;
  auto at = nowhere;  // the field of the source that the position is at
  for (const auto& one : all) {
    const bool continues = one.source != nullptr && at == one.source_index;
    seeks.push_back(one.source != nullptr && !continues);
    if (one.source != nullptr) {
      if (!continues) marked[one.source_index] = true;
      at = one.source_index + 1;
    } else if (one.rule != nullptr && one.rule->kind != Source::Kind::kValue) {
      collect_roots(*one.rule, pair.from, marked);
      at = nowhere;
    }
  }
  out_.flush(pair.path);
  pair.slots.assign(fields.size(), 0);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (marked[i]) out_.mark(pair.slots[i] = out_.new_slot(), pair.path + fields[i].name);
    if (auto done = skip(fields[i], pair.path + fields[i].name); !done) return done;
  }
  const auto end = out_.new_slot();
  out_.mark(end, pair.path);
  out_.anchor(pair.path);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (seeks[i]) out_.seek(pair.slots[all[i].source_index], pair.path + all[i].target->name);
    if (auto done = piece(pair, all[i]); !done) return done;
  }
  out_.seek(end, pair.path);
  return {};
}

Result<void> Compiler::piece(Pair& pair, const Piece& one) {
  if (auto done = spend(); !done) return done;
  const auto path = pair.path + one.target->name;
  if (one.source != nullptr) return paired(pair, one);
  if (one.rule == nullptr) {
    note(NoteKind::kDefaulted, path, "new: zero or empty");
    out_.zero(min_size(*one.target), path);
    return {};
  }
  note(NoteKind::kRule, path, to_text(*one.rule));
  const bool before = std::exchange(quiet_, true);
  auto done = source(pair, *one.rule, *one.target, path);
  quiet_ = before;
  return done;
}

Result<void> Compiler::paired(Pair& pair, const Piece& one) {
  const auto path = pair.path + one.target->name;
  const auto note_at = notes_.size();
  const auto changes = out_.changes();
  const bool reinterprets = std::exchange(out_.code().reinterprets, false);
  if (auto done = field(*one.source, *one.target, {one.rule}, path); !done) return done;
  const bool kept = !out_.code().reinterprets && out_.changes() == changes;
  out_.code().reinterprets = out_.code().reinterprets || reinterprets;
  if (quiet_) return {};
  Plan::Note about{NoteKind::kKept, path, "copied"};
  if (one.rule != nullptr) {
    about = {NoteKind::kRule, path, to_text(*one.rule)};
  } else if (!kept) {
    about = {NoteKind::kConverted, path, conversion_text(*one.source, *one.target, options_)};
  } else if (one.moved) {
    about = {NoteKind::kMoved, path, "moved: was field " + std::to_string(one.source_index + 1)};
  }
  const auto at = notes_.begin() + static_cast<std::ptrdiff_t>(note_at);
  if (kept) notes_.erase(at, notes_.end());
  notes_.insert(notes_.begin() + static_cast<std::ptrdiff_t>(note_at), about);
  return {};
}

void Compiler::note_dropped(const Pair& pair, const std::vector<Piece>& all) {
  std::vector<bool> used(pair.from.fields().size(), false);
  for (const auto& one : all) {
    if (one.source != nullptr) used[one.source_index] = true;
    if (one.rule != nullptr) collect_roots(*one.rule, pair.from, used);
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i]) continue;
    const auto& name = pair.from.fields()[i].name;
    const bool wanted =
        pair.rule != nullptr && std::count(pair.rule->dropped.begin(), pair.rule->dropped.end(), name);
    note(NoteKind::kDropped, pair.path + name,
         wanted ? "dropped by a rule" : "dropped: the target has no such field");
  }
}

Result<void> Compiler::chain(const std::vector<RuleSet::Link>& links, const SchemaPtr& from,
                             const std::string& path) {
  auto stages = compile_chain(links, rules_, options_, budget_);
  if (!stages) return tl::unexpected(Error{stages.error().code, path + ": " + stages.error().message});
  Op op{OpCode::kChain};
  op.extra = static_cast<std::uint32_t>(out_.code().chains.size());
  out_.code().chains.push_back(std::move(stages->stages));
  const auto at = out_.begin(op, path);
  for (const auto& field : from->fields())
    if (auto done = skip(field, path + "." + field.name); !done) return done;
  out_.end_body(at);
  note(NoteKind::kRule, path, "through " + std::to_string(links.size()) + " rules, one after the other");
  return {};
}

Result<Chain> compile_chain(const std::vector<RuleSet::Link>& links, const RuleSet& rules,
                            const PlanOptions& options, Budget& budget) {
  if (budget.depth == 0) return fail(ErrorCode::kUnsupported, "rules form a cycle");
  --budget.depth;
  Chain chain;
  for (std::size_t i = 0; i < links.size(); ++i) {
    auto of_stage = options;  // stamps are shifted once, and frames get their slash once
    if (i != 0) of_stage.shift_times = false;
    if (i + 1 != links.size()) of_stage.frame_slash = PlanOptions::Slash::kKeep;
    const auto dropped = [](const Plan::Note& note) { return note.kind == Plan::Note::Kind::kDropped; };
    std::vector<Plan::Note> notes;
    auto code = Compiler(rules, of_stage, budget, notes).compile(*links[i].from, *links[i].to, links[i].rule);
    if (!code) return tl::unexpected(code.error());
    chain.stages.push_back(std::move(*code));
    if (i + 1 != links.size())
      notes.erase(std::remove_if(notes.begin(), notes.end(), std::not_fn(dropped)), notes.end());
    chain.notes.insert(chain.notes.end(), notes.begin(), notes.end());
  }
  ++budget.depth;
  return chain;
}

}  // namespace extperfc::translate::plan
