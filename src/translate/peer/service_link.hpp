#pragma once

#include <functional>
#include <memory>
#include <string>

#include "translate/peer/peer_core.hpp"

namespace extperfc::translate {

/// Looks a service up, connects and shakes hands; `done` runs once, unless the node is closed before.
void open_service_link(const std::shared_ptr<PeerCore>& core, const std::string& service,
                       const std::string& md5, bool probe,
                       std::function<void(Result<std::shared_ptr<ServiceLink>>)> done);

}  // namespace extperfc::translate
