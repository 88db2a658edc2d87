#pragma once

#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// Which classes of a detector count.
class ClassFilter {
 public:
  /// All of them.
  ClassFilter() = default;

  /// Those of a list, "cube, 2": names, or indices from 0 upwards, between commas; all of them when it is
  /// empty. `names` are the detector's, by index; kInvalidArgument names the first entry that is neither one
  /// of them nor an index of one. While `names` is empty, any index is accepted.
  [[nodiscard]] static Result<ClassFilter> make(const std::string& list,
                                                const std::vector<std::string>& names);

  [[nodiscard]] bool allows(int class_index) const;
  [[nodiscard]] bool allows_all() const { return indices_.empty(); }

 private:
  std::vector<int> indices_;  // sorted; empty: all
};

}  // namespace extperfc
