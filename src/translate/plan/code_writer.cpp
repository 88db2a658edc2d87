#include "translate/plan/code_writer.hpp"

#include <algorithm>
#include <limits>

namespace extperfc::translate {

namespace {

/// True when nothing is wanted after it that is not copied.
bool writes(OpCode code) {
  return code >= OpCode::kEmit && code != OpCode::kMap && code != OpCode::kChain;
}

}  // namespace

std::uint32_t CodeWriter::narrow(std::uint64_t size) {
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint32_t>::max();
  if (size <= kMax) return static_cast<std::uint32_t>(size);
  overflowed_ = true;
  return 0;
}

Op* CodeWriter::joinable(OpCode code) {
  auto& ops = code_.ops;
  return ops.size() > barrier_ && ops.back().code == code ? &ops.back() : nullptr;
}

void CodeWriter::extend_remark(const std::string& path) {
  auto& remark = code_.remarks.back();
  if (remark.first != path) remark.last = path;
}

void CodeWriter::drop_from(std::size_t at) {
  code_.ops.resize(at);
  code_.remarks.resize(at);
  barrier_ = std::min(barrier_, at);
}

std::size_t CodeWriter::append(const Op& op, const std::string& path) {
  if (!only_scans(op.code)) ++changes_;
  code_.ops.push_back(op);
  code_.remarks.push_back({path, ""});
  return code_.ops.size() - 1;
}

void CodeWriter::skip(std::uint64_t bytes, const std::string& path) {
  if (bytes == 0) return;
  if (auto* before = joinable(OpCode::kSkip)) {
    before->size = narrow(before->size + bytes);
    extend_remark(path);
    return;
  }
  Op op{OpCode::kSkip};
  op.size = narrow(bytes);
  append(op, path);
}

void CodeWriter::skip_array(std::uint32_t element_size, const std::string& path) {
  Op op{OpCode::kSkipArray};
  op.size = element_size;
  append(op, path);
}

void CodeWriter::flush(const std::string& path) {
  if (joinable(OpCode::kAnchor) != nullptr) {  // nothing is wanted yet: what follows goes on not being wanted
    drop_from(code_.ops.size() - 1);
    return;
  }
  const bool copied = code_.ops.size() > barrier_ && writes(code_.ops.back().code);
  if (!copied) append(Op{OpCode::kFlush}, path);
}

void CodeWriter::anchor(const std::string& path) {
  append(Op{OpCode::kAnchor}, path);
}

void CodeWriter::mark(std::uint32_t slot, const std::string& path) {
  Op op{OpCode::kMark};
  op.extra = slot;
  append(op, path);
}

void CodeWriter::seek(std::uint32_t slot, const std::string& path) {
  Op op{OpCode::kSeek};
  op.extra = slot;
  append(op, path);
}

void CodeWriter::emit(ByteView constant, const std::string& path) {
  if (constant.size == 0) return;
  ++changes_;
  auto& constants = code_.constants;
  const auto at = narrow(constants.size());
  constants.insert(constants.end(), constant.data, constant.data + constant.size);
  auto* before = joinable(OpCode::kEmit);
  if (before != nullptr && before->extra + before->size == at) {
    before->size = narrow(before->size + constant.size);
    extend_remark(path);
    return;
  }
  Op op{OpCode::kEmit};
  op.size = narrow(constant.size);
  op.extra = at;
  append(op, path);
}

void CodeWriter::zero(std::uint64_t bytes, const std::string& path) {
  if (bytes == 0) return;
  ++changes_;
  bytes = narrow(bytes);
  if (auto* before = joinable(OpCode::kZero)) {
    before->size = narrow(before->size + bytes);
    extend_remark(path);
    return;
  }
  Op op{OpCode::kZero};
  op.size = narrow(bytes);
  append(op, path);
}

std::size_t CodeWriter::begin(const Op& op, const std::string& path) {
  barriers_.push_back(barrier_);
  return append(op, path);
}

void CodeWriter::end_body(std::size_t at) {
  barriers_.pop_back();
  code_.ops[at].body = narrow(code_.ops.size() - at - 1);
  barrier_ = code_.ops.size();
}

void CodeWriter::end_loop(std::size_t at) {
  end_body(at);
  Op& loop = code_.ops[at];
  if (loop.body > 1) return;
  const Op body = loop.body == 0 ? Op{OpCode::kSkip} : code_.ops[at + 1];
  Op whole{OpCode::kSkipArray};
  whole.size = body.size;
  if (body.code == OpCode::kSkipArray && body.size == 1) {
    whole = Op{OpCode::kSkipStrings};
  } else if (body.code == OpCode::kZero && loop.size == 0) {
    whole.code = OpCode::kZeroArray;
  } else if (body.code != OpCode::kSkip) {
    return;
  }
  loop = whole;
  drop_from(at + 1);
}

void CodeWriter::end_repeat(std::size_t at) {
  const auto before = barriers_.back();
  end_body(at);
  const Op repeat = code_.ops[at];
  const bool single_skip = repeat.body == 1 && code_.ops[at + 1].code == OpCode::kSkip;
  if (repeat.size != 0 && repeat.body != 0 && !single_skip) return;
  const auto bytes = single_skip ? std::uint64_t{repeat.size} * code_.ops[at + 1].size : 0;
  const auto path = code_.remarks[at].first;
  drop_from(at);
  barrier_ = before;
  skip(bytes, path);
}

std::uint32_t CodeWriter::here() {
  barrier_ = code_.ops.size();
  return narrow(code_.ops.size());
}

}  // namespace extperfc::translate
