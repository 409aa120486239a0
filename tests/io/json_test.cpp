// SPDX-License-Identifier: MIT
#include <jampack/io/json.hpp>
#include <limits>
#include <vector>

#include "../catch.hpp"

using namespace jampack;

TEST_CASE("JSON members keep their order and nest") {
  Json json;
  json["seed"] = 7;
  json["name"] = "two\nlines, \"quoted\" \\ \t\x01";
  json["done"] = true;
  json["timings"]["seconds"] = 0.1;
  json["timings"]["steps"] = Index(12);
  json["seed"] = 8;
  CHECK(json.text() ==
        "{\n  \"seed\": 8,\n  \"name\": \"two\\nlines, \\\"quoted\\\" \\\\ \\t\\u0001\",\n  \"done\": true,\n"
        "  \"timings\": {\n    \"seconds\": 0.1,\n    \"steps\": 12\n  }\n}");
}

TEST_CASE("JSON has no NaN or infinity: null instead") {
  CHECK(Json(std::numeric_limits<double>::quiet_NaN()).text() == "null");
  CHECK(Json(-std::numeric_limits<double>::infinity()).text() == "null");
  CHECK(Json().text() == "null");
}

TEST_CASE("JSON arrays hold numbers, texts and objects") {
  CHECK(Json(Array<double>{1, 0.5, 1e-300}).text() == "[1, 0.5, 1e-300]");
  CHECK(Json(std::vector<std::string>{"a", "b"}).text() == "[\"a\", \"b\"]");
  CHECK(Json::array().text() == "[]");
  CHECK(Json::object().text() == "{}");
  Json list;
  list.push_back(1);
  Json member;
  member["phi"] = 0.9;
  list.push_back(member);
  CHECK(list.text() == "[1, {\n    \"phi\": 0.9\n  }]");
}

TEST_CASE("numbers read back exactly") {
  for (const double number : {0.1, 1.0 / 3.0, 1e308, 5e-324, -2.5, 0.0}) {
    CHECK(to_number<double>(to_text(number)) == number);
    CHECK(to_number<double>(Json(number).text()) == number);
  }
  CHECK_FALSE(to_number<double>("1.0 ").has_value());
  CHECK_FALSE(to_number<double>("").has_value());
  CHECK_FALSE(to_number<double>("1e999").has_value());
  CHECK_FALSE(to_number<int>("1.0").has_value());
}
