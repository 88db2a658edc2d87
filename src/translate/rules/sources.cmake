# Sources of the rules, relative to src/translate/plan.
set(EXTPERFC_RULES_SOURCES
  ../rules/rule_set.cpp)
