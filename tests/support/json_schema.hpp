// A structural JSON Schema validator: type, enum, required, properties, additionalProperties, items, minItems,
// maxItems, minimum. A schema that uses any other keyword (but for remarks) is itself reported, so that nothing is
// skipped silently.
#pragma once
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace isopach::test {

class SchemaCheck {
 public:
  using Json = nlohmann::ordered_json;

  /// One line per violation; empty if `value` is valid.
  static std::vector<std::string> violations(const Json& schema, const Json& value) {
    SchemaCheck check;
    check.visit(schema, value, "$");
    return check.found_;
  }

 private:
  static bool has_type(const Json& v, const std::string& type) {
    if (type == "object") return v.is_object();
    if (type == "array") return v.is_array();
    if (type == "string") return v.is_string();
    if (type == "boolean") return v.is_boolean();
    if (type == "null") return v.is_null();
    if (type == "integer") return v.is_number_integer();
    if (type == "number") return v.is_number();
    return false;
  }

  void visit(const Json& schema, const Json& value, const std::string& where) {
    static const std::set<std::string> known{"$schema",     "$id",        "title",
                                             "description", "type",       "enum",
                                             "required",    "properties", "additionalProperties",
                                             "items",       "minItems",   "maxItems",
                                             "minimum",     "maximum"};
    for (const auto& [key, unused] : schema.items())
      if (known.count(key) == 0) report(where, "the schema uses \"" + key + "\", which is not checked");
    if (schema.contains("type")) {
      const Json& type = schema["type"];
      bool fits = false;
      for (const Json& t : type.is_array() ? type : Json::array({type})) fits = fits || has_type(value, t);
      if (!fits) return report(where, "is " + value.dump() + ", not of type " + type.dump());
    }
    if (schema.contains("enum")) {
      bool fits = false;
      for (const Json& allowed : schema["enum"]) fits = fits || allowed == value;
      if (!fits) report(where, "is " + value.dump() + ", not one of " + schema["enum"].dump());
    }
    if (value.is_number() && schema.contains("minimum") && value.get<double>() < schema["minimum"].get<double>())
      report(where, "is below the minimum");
    if (value.is_number() && schema.contains("maximum") && value.get<double>() > schema["maximum"].get<double>())
      report(where, "is above the maximum");
    if (value.is_object()) visit_object(schema, value, where);
    if (value.is_array()) visit_array(schema, value, where);
  }

  void visit_object(const Json& schema, const Json& value, const std::string& where) {
    if (schema.contains("required"))
      for (const Json& key : schema["required"])
        if (!value.contains(key.get<std::string>())) report(where, "lacks " + key.dump());
    for (const auto& [key, member] : value.items()) {
      const std::string there = where + "." + key;
      if (schema.contains("properties") && schema["properties"].contains(key))
        visit(schema["properties"][key], member, there);
      else if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object())
        visit(schema["additionalProperties"], member, there);
      else if (schema.contains("additionalProperties") && schema["additionalProperties"] == false)
        report(there, "is not allowed");
    }
  }

  void visit_array(const Json& schema, const Json& value, const std::string& where) {
    if (schema.contains("minItems") && value.size() < schema["minItems"].get<std::size_t>())
      report(where, "is too short");
    if (schema.contains("maxItems") && value.size() > schema["maxItems"].get<std::size_t>())
      report(where, "is too long");
    if (!schema.contains("items")) return;
    for (std::size_t i = 0; i < value.size(); ++i)
      visit(schema["items"], value[i], where + "[" + std::to_string(i) + "]");
  }

  void report(const std::string& where, const std::string& what) { found_.push_back(where + " " + what); }

  std::vector<std::string> found_;
};

}  // namespace isopach::test
