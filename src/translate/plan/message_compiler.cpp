#include "translate/plan/message_compiler.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "translate/plan/field_size.hpp"

namespace extperfc::translate {

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

std::vector<MessageCompiler::Piece> MessageCompiler::pieces() const {
  std::vector<Piece> all;
  std::size_t beyond = 0;  // the last one read so far
  for (const auto& target : pair_.to.fields()) {
    Piece one;
    one.target = &target;
    one.rule = rule_of(pair_.rule, target.name);
    const bool by_field = one.rule == nullptr || is_whole_field(*one.rule);
    const auto& name = one.rule != nullptr && by_field ? one.rule->path.front().field : target.name;
    const auto index = by_field ? index_of(pair_.from, name) : std::nullopt;
    if (index) {
      one.source = &pair_.from.fields()[*index];
      one.source_index = *index;
      one.moved = *index < beyond;
      beyond = std::max(beyond, *index + 1);
    }
    all.push_back(one);
  }
  return all;
}

Result<void> MessageCompiler::compile() {
  const auto all = pieces();
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
  auto done = in_order ? streamed(all) : scanned(all);
  if (done) note_dropped(all);
  return done;
}

void MessageCompiler::drop(std::size_t first, std::size_t last) {
  if (first >= last) return;
  const auto& fields = pair_.from.fields();
  out_.flush(pair_.path + fields[first].name);
  for (std::size_t i = first; i < last; ++i) fields_.skip(fields[i], pair_.path + fields[i].name);
  out_.anchor(pair_.path + fields[last - 1].name);
}

Result<void> MessageCompiler::streamed(const std::vector<Piece>& all) {
  std::size_t next = 0;
  for (const auto& one : all) {
    if (one.source != nullptr) {
      drop(next, one.source_index);
      next = one.source_index + 1;
    }
    if (auto done = piece(one); !done) return done;
  }
  drop(next, pair_.from.fields().size());
  return {};
}

Result<void> MessageCompiler::scanned(const std::vector<Piece>& all) {
  const auto& fields = pair_.from.fields();
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
      collect_roots(*one.rule, pair_.from, marked);
      at = nowhere;
    }
  }
  out_.flush(pair_.path);
  pair_.slots.assign(fields.size(), 0);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (marked[i]) out_.mark(pair_.slots[i] = out_.new_slot(), pair_.path + fields[i].name);
    if (auto done = fields_.skip(fields[i], pair_.path + fields[i].name); !done) return done;
  }
  const auto end = out_.new_slot();
  out_.mark(end, pair_.path);
  out_.anchor(pair_.path);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (seeks[i]) out_.seek(pair_.slots[all[i].source_index], pair_.path + all[i].target->name);
    if (auto done = piece(all[i]); !done) return done;
  }
  out_.seek(end, pair_.path);
  return {};
}

Result<void> MessageCompiler::piece(const Piece& one) {
  if (auto done = compiler_.spend(); !done) return done;
  const auto path = pair_.path + one.target->name;
  if (one.source != nullptr) return paired(one);
  if (one.rule == nullptr) {
    compiler_.note(NoteKind::kDefaulted, path, "new: zero or empty");
    out_.zero(min_size(*one.target), path);
    return {};
  }
  compiler_.note(NoteKind::kRule, path, to_string(*one.rule));
  const bool before = compiler_.set_quiet(true);
  auto done = sources_.compile(*one.rule, *one.target, path);
  compiler_.set_quiet(before);
  return done;
}

Result<void> MessageCompiler::paired(const Piece& one) {
  const auto path = pair_.path + one.target->name;
  auto& notes = compiler_.notes();
  const auto note_at = notes.size();
  const auto changes = out_.changes();
  const bool reinterprets = std::exchange(out_.code().reinterprets, false);
  if (auto done = fields_.compile(*one.source, *one.target, {one.rule}, path); !done) return done;
  const bool kept = !out_.code().reinterprets && out_.changes() == changes;
  out_.code().reinterprets = out_.code().reinterprets || reinterprets;
  if (compiler_.quiet()) return {};
  Plan::Note about{NoteKind::kKept, path, "copied"};
  if (one.rule != nullptr) {
    about = {NoteKind::kRule, path, to_string(*one.rule)};
  } else if (!kept) {
    about = {NoteKind::kConverted, path, conversion_text(*one.source, *one.target, compiler_.options())};
  } else if (one.moved) {
    about = {NoteKind::kMoved, path, "moved: was field " + std::to_string(one.source_index + 1)};
  }
  const auto at = notes.begin() + static_cast<std::ptrdiff_t>(note_at);
  if (kept) notes.erase(at, notes.end());
  notes.insert(notes.begin() + static_cast<std::ptrdiff_t>(note_at), about);
  return {};
}

void MessageCompiler::note_dropped(const std::vector<Piece>& all) {
  std::vector<bool> used(pair_.from.fields().size(), false);
  for (const auto& one : all) {
    if (one.source != nullptr) used[one.source_index] = true;
    if (one.rule != nullptr) collect_roots(*one.rule, pair_.from, used);
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i]) continue;
    const auto& name = pair_.from.fields()[i].name;
    const bool wanted =
        pair_.rule != nullptr && std::count(pair_.rule->dropped.begin(), pair_.rule->dropped.end(), name);
    compiler_.note(NoteKind::kDropped, pair_.path + name,
                   wanted ? "dropped by a rule" : "dropped: the target has no such field");
  }
}

}  // namespace extperfc::translate
