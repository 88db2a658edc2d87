#pragma once

#include <ostream>

#include "extperfc/offline/relations.hpp"

#include "offline/json_writer.hpp"

namespace extperfc::offline::tool {

/// Table of the groups, and the `worst` relations with the largest errors.
void print_score(std::ostream& out, const std::vector<Relation>& relations, const RelationsScore& score,
                 std::size_t worst);

/// As one object under `key`.
void write_score(JsonWriter& json, const char* key, const std::vector<Relation>& relations,
                 const RelationsScore& score, std::size_t worst);

}  // namespace extperfc::offline::tool
