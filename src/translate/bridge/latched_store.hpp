#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/translate/frame.hpp"

#include "translate/bridge/plan_cache.hpp"

namespace extperfc::translate {

/// The last message of each latching publisher of a topic, for subscribers that come later. A publisher keeps
/// its entry until the master forgets it.
class LatchedStore {
 public:
  struct Entry {
    std::string origin;  ///< caller id
    MessageDefinition definition;
    FramePtr frame;
  };

  void keep(const std::string& origin, const MessageDefinition& definition, FramePtr frame);
  void forget(const std::string& origin);
  /// The oldest message first.
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

  /// All entries as one message of tf2_msgs/TFMessage: a listener keeps one latched message per connection,
  /// and the transforms of several broadcasters come to it through one of ours. Nothing unless there are
  /// several entries of one version. Each is [count][transforms].
  [[nodiscard]] std::optional<Entry> merged_transforms(FramePool& frames) const;

 private:
  std::vector<Entry> entries_;
};

}  // namespace extperfc::translate
