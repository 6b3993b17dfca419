#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "core/parallel/binned_sum.h"

using namespace loomstone;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double largest = std::numeric_limits<double>::max();
constexpr double least = std::numeric_limits<double>::denorm_min();

BinnedSum sum_of(const std::vector<double>& numbers) {
  BinnedSum sum;
  for (const double number : numbers) sum.add(number);
  return sum;
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// Random numbers of both signs: fractions below 1 times powers of two from 2^-range to 2^range.
std::vector<double> numbers_of(int n, int range, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<double> numbers(n);
  for (double& number : numbers) {
    const double mantissa = static_cast<double>(random()) / 4294967296.0 +
                            static_cast<double>(random()) / 18446744073709551616.0;
    const int exponent = static_cast<int>(random() % (2 * range + 1)) - range;
    number = std::ldexp(random() % 2 == 0 ? mantissa : -mantissa, exponent);
  }
  return numbers;
}

// Returns the sum of the numbers, computed by adding sums of random subsets in random order.
double sum_of_parts(const std::vector<double>& numbers, std::mt19937& random) {
  std::vector<BinnedSum> parts(1 + random() % 7);
  for (const double number : numbers) parts[random() % parts.size()].add(number);
  while (parts.size() > 1) {
    std::swap(parts[random() % parts.size()], parts.back());
    const BinnedSum last = parts.back();
    parts.pop_back();
    parts[random() % parts.size()].add(last);
  }
  return parts[0].value();
}

}  // namespace

TEST_CASE("a binned sum has the same bits for every order and division of its numbers") {
  std::mt19937 random(1);
  for (const int range : {0, 3, 40, 300, 1000}) {
    std::vector<double> numbers = numbers_of(500, range, 7 + range);
    const double expected = sum_of(numbers).value();
    CHECK(std::isfinite(expected));
    for (int round = 0; round < 50; ++round) {
      std::shuffle(numbers.begin(), numbers.end(), random);
      CHECK(same_bits(sum_of(numbers).value(), expected));
      CHECK(same_bits(sum_of_parts(numbers, random), expected));
    }
  }
}

TEST_CASE("a binned sum of numbers of similar size is exact up to one rounding") {
  // The numbers have similar exponents, so all bits of a number are kept.
  for (const int scale : {-900, -30, 0, 900}) {
    const std::vector<double> numbers = numbers_of(1000, 10, 3);
    BinnedSum sum;
    __int128 exact = 0;  // exact sum in units of 2^-74
    for (const double number : numbers) {
      sum.add(std::ldexp(number, scale));
      exact += static_cast<__int128>(std::ldexp(number, 74));
    }
    CHECK(sum.value() == std::ldexp(static_cast<double>(exact), scale - 74));
  }
}

TEST_CASE("the error of a binned sum is below n m 2^-95 plus one rounding") {
  // The large numbers cancel, so the rounding of small numbers is visible in the sum.
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> numbers;
    __int128 exact = 0;  // exact sum in units of 2^-120
    for (int i = 0; i < 20; ++i) {
      const double large = numbers_of(1, 0, random())[0];
      const double small = std::ldexp(numbers_of(1, 0, random())[0], -static_cast<int>(i));
      const double tiny = static_cast<double>(random()) * 0x1p-120;
      for (const double number : {large, -large, small * 0x1p-30, tiny}) {
        numbers.push_back(std::ldexp(std::trunc(std::ldexp(number, 120)), -120));
        exact += static_cast<__int128>(std::ldexp(numbers.back(), 120));
      }
    }
    const __int128 got = static_cast<__int128>(std::ldexp(sum_of(numbers).value(), 120));
    const double error = std::abs(static_cast<double>(got - exact));
    CHECK(error <= 80 * 0x1p25 + std::abs(static_cast<double>(exact)) * 0x1p-53);
  }
}

TEST_CASE("numbers that cancel leave exactly what remains") {
  CHECK(sum_of({1e20, 1.0, -1e20}).value() == 1.0);
  // The sum of the small terms is less than half a unit in the last place of 1.
  CHECK(sum_of({1.0, 1e-17, 1e-17}).value() == 1.0);
  CHECK(sum_of({1e16, 1.0, 1.0, -1e16, -2.0}).value() == 0.0);
  CHECK(sum_of({-3.5, 1.25}).value() == -2.25);
  CHECK(sum_of({3.0, 0x1p-60, -3.0}).value() == 0x1p-60);
  CHECK(sum_of({least, least, -3 * least}).value() == -least);
  CHECK(sum_of({}).value() == 0.0);
  CHECK(!std::signbit(sum_of({-0.0, -0.0}).value()));
  // 2^53 + 1 lies half-way between two doubles. It rounds to the even one, 2^53, unless more is
  // added.
  CHECK(sum_of({0x1p53, 1.0}).value() == 0x1p53);
  CHECK(sum_of({0x1p53, 1.0, 0x1p-40}).value() == 0x1p53 + 2.0);
  CHECK(sum_of({-0x1p53, -1.0, -0x1p-40}).value() == -0x1p53 - 2.0);
}

TEST_CASE("a binned sum passes through infinity only if its value does") {
  CHECK(sum_of({largest, largest, -largest}).value() == largest);
  CHECK(sum_of({largest, largest}).value() == infinity);
  CHECK(sum_of({-largest, -largest}).value() == -infinity);
}

TEST_CASE("a NaN stays NaN and an infinity stays infinite in every order") {
  const double nan = std::nan("");
  for (const std::vector<double>& numbers :
       {std::vector<double>{nan, 1.0}, {1.0, nan, infinity}, {infinity, 2.0, -infinity}})
    CHECK(std::isnan(sum_of(numbers).value()));
  CHECK(sum_of({1.0, infinity, infinity}).value() == infinity);
  CHECK(sum_of({-infinity, 1e300}).value() == -infinity);
  BinnedSum sum = sum_of({1.0, 2.0});
  sum.add(sum_of({nan}));
  CHECK(std::isnan(sum.value()));
  sum = sum_of({infinity});
  sum.add(sum_of({-infinity}));
  CHECK(std::isnan(sum.value()));
}

TEST_CASE("many numbers of the largest mantissa do not overflow a bin") {
  BinnedSum once;
  const double number = std::nextafter(2.0, 0.0);
  once.add(number);
  for (int doubling = 0; doubling < 30; ++doubling) {
    const BinnedSum same = once;
    once.add(same);
  }
  CHECK(once.value() == std::ldexp(number, 30));  // 2^30 numbers
}
