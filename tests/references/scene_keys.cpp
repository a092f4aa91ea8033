// Prints what the readers of scenes ask for, as JSON, for the reference that tests/references.py
// writes: scene_keys SCENE.yaml ...
#include <iostream>

#include <nlohmann/json.hpp>

#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const KeyRecord& record) {
  Json json{{"path", record.path},           {"kind", record.kind},   {"accepted", record.accepted},
            {"units", record.units},         {"words", record.words}, {"defaults", record.defaults},
            {"required", record.is_required}};
  json["place"] = record.place.file + (":" + std::to_string(record.place.line));
  json["text"] = record.text ? Json(*record.text) : Json();
  return json;
}

// The records of one scene, and its mistakes.
Json RecordsOf(const std::string& file, SceneUse use) {
  Json json{{"scene", file}, {"full", use == SceneUse::kFull}, {"mistakes", ""}};
  KeyRecords().clear();
  try {
    LoadScene(file, {}, use);
  } catch (const SceneError& error) {
    json["mistakes"] = error.what();
  }
  for (const KeyRecord& record : KeyRecords()) json["keys"].push_back(ToJson(record));
  return json;
}

}  // namespace
}  // namespace palpate

int main(int count, char** arguments) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (int i = 1; i < count; ++i) {
    for (const auto use : {palpate::SceneUse::kFull, palpate::SceneUse::kSolve}) {
      all.push_back(palpate::RecordsOf(arguments[i], use));
    }
  }
  std::cout << all.dump(1) << '\n';
}
