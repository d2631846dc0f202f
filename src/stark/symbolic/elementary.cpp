// Argument reductions are classical [Muller 2016, "Elementary Functions", ch. 11; Cody & Waite 1980]. The
// polynomials are minimax fits made for this file by the Remez algorithm in 60 digits; the error quoted
// beside each is that of the exact polynomial, relative to the function. Phase: kernel building.
#include <stark/symbolic/elementary.h>

#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace stark::symbolic {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr uint64_t kSignBit = 0x8000000000000000ull;

constexpr double kExp[] = {0x1.000000000000cp-1,  0x1.5555555555561p-3,  0x1.555555554ff92p-5,
                           0x1.111111110d5d6p-7,  0x1.6c16c185cadccp-10, 0x1.a01a01bb0494ep-13,
                           0x1.a0199630aa6eap-16, 0x1.71dddf7dcbdc9p-19, 0x1.28b0a716ec81fp-22,
                           0x1.af860595d8bbfp-26};  // 2^-58.0
constexpr double kLog[] = {0x1.5555555555593p-1, 0x1.999999997fb34p-2, 0x1.249249421787dp-2,
                           0x1.c71c51e80442cp-3, 0x1.7466462b0f919p-3, 0x1.39a0f5130ff64p-3,
                           0x1.2f0d8e947b4f2p-3};  // 2^-59.4
constexpr double kPow[] = {0x1.9999999999996p-2, 0x1.2492492493049p-2, 0x1.c71c71c57dff3p-3,
                           0x1.745d18337acd8p-3, 0x1.3b13626715856p-3, 0x1.1120c18198ed9p-3,
                           0x1.de318e2a6c7c2p-4, 0x1.eb20d75ea9a7fp-4};  // 2^-73
constexpr double kSin[] = {-0x1.5555555555549p-3, 0x1.111111110f841p-7,   -0x1.a01a019c0a27ap-13,
                           0x1.71de3570fcd83p-19, -0x1.ae5e60c458434p-26, 0x1.5d915e0e0d0c8p-33};  // 2^-58.0
constexpr double kCos[] = {0x1.555555555554cp-5,   -0x1.6c16c16c15140p-10, 0x1.a01a019cab760p-16,
                           -0x1.27e4f805351a7p-22, 0x1.1ee9e891a8e28p-29,  -0x1.8facd1d43a60cp-37};  // 2^-64
constexpr double kAtan[] = {-0x1.555555555553dp-2, 0x1.9999999995864p-3,  -0x1.24924922ad9cap-3,
                            0x1.c71c70e632ce3p-4,  -0x1.745cf8e03a8f5p-4, 0x1.3b11195029738p-4,
                            -0x1.10ebb9916209fp-4, 0x1.df0f4cd3768d4p-5,  -0x1.9cd270ce51f23p-5,
                            0x1.37d407d3bed50p-5,  -0x1.2564eb60481c0p-6};  // 2^-59.5
constexpr double kAsin[] = {0x1.5555555555578p-3, 0x1.333333332de8ap-4, 0x1.6db6db723206dp-5,
                            0x1.f1c71a890feddp-6, 0x1.6e8be030683cfp-6, 0x1.1c49d8af7e720p-6,
                            0x1.ca21c736ea564p-7, 0x1.757342eb73c20p-7, 0x1.61a35adf57fe8p-7,
                            0x1.dfde88c94024ap-9, 0x1.657864760e5b0p-6, -0x1.5aa1ad88ef090p-6,
                            0x1.0c1b0ad0bb528p-5};  // 2^-59.8

// pi/2 = kHalfPi1 + kHalfPi2 + kHalfPi3, each part with 53 bits.
constexpr double kHalfPi1 = 0x1.921fb54442d18p+0, kHalfPi2 = 0x1.1a62633145c07p-54,
                 kHalfPi3 = -0x1.f1976b7ed8fbcp-110;
// ln 2 = kLn2High + kLn2Low; the 11 low bits of the high part are zero, so that k kLn2High is exact.
constexpr double kLn2High = 0x1.62e42fefa3800p-1, kLn2Low = 0x1.ef35793c76730p-45;

/// Value as an unevaluated sum, |low| at most half an ulp of high.
struct Pair {
  LowId high, low;
};

Pair two_sum(ProgramBuilder& p, LowId a, LowId b) {
  const LowId s = p.add(a, b), t = p.sub(s, a);
  return {s, p.add(p.sub(a, p.sub(s, t)), p.sub(b, t))};
}
Pair fast_two_sum(ProgramBuilder& p, LowId a, LowId b) {
  const LowId s = p.add(a, b);
  return {s, p.sub(b, p.sub(s, a))};
}
Pair two_product(ProgramBuilder& p, LowId a, LowId b) {
  const LowId h = p.mul(a, b);
  return {h, p.mul_sub(a, b, h)};
}

LowId horner(ProgramBuilder& p, LowId x, std::span<const double> c) {
  LowId r = p.constant(c.back());
  for (size_t k = c.size() - 1; k-- > 0;) r = p.mul_add(r, x, p.constant(c[k]));
  return r;
}

// Even and odd parts side by side: half the latency of one chain for one more multiplication.
LowId polynomial(ProgramBuilder& p, LowId x, std::span<const double> c) {
  std::vector<double> even, odd;
  for (size_t k = 0; k < c.size(); ++k) (k % 2 ? odd : even).push_back(c[k]);
  const LowId x2 = p.mul(x, x);
  return p.mul_add(horner(p, x2, odd), x, horner(p, x2, even));
}

LowId sign_of(ProgramBuilder& p, LowId x) { return p.emit(Code::And, x, p.bits(kSignBit)); }
LowId absolute(ProgramBuilder& p, LowId x) { return p.emit(Code::And, x, p.bits(~kSignBit)); }
LowId with_sign(ProgramBuilder& p, LowId x, LowId sign) { return p.emit(Code::Xor, x, sign); }

// 2^n for an integral double n in [-1022, 1023]: n + 1023 lands in the low mantissa bits and moves to the
// exponent.
LowId power_of_two(ProgramBuilder& p, LowId n) {
  return p.emit(Code::ShiftLeft, p.add(n, p.constant(0x1p52 + 1023.0)), -1, -1, 52);
}

// x 2^n for n in [-1100, 1100], in two steps so that the result may overflow or become subnormal.
LowId scale(ProgramBuilder& p, LowId x, LowId n) {
  const LowId half = p.emit(Code::Round, p.mul(n, p.constant(0.5)));
  return p.mul(p.mul(x, power_of_two(p, half)), power_of_two(p, p.sub(n, half)));
}

// x = n ln 2 + r, |r| <= ln 2 / 2; returns n, r and r^2 q(r) = exp(r) - 1 - r.
struct ExpReduction {
  LowId n, r, tail;
};
ExpReduction reduce_exp(ProgramBuilder& p, LowId x, LowId x_low) {
  const LowId n = p.emit(Code::Round, p.mul(x, p.constant(0x1.71547652b82fep+0)));
  const LowId r_high = p.neg_mul_add(n, p.constant(kLn2High), x);
  LowId low = p.mul(n, p.constant(-kLn2Low));
  if (x_low >= 0) low = p.add(low, x_low);
  const LowId r = p.add(r_high, low);
  const LowId r_error = p.add(p.sub(r_high, r), low);
  const LowId tail = p.mul_add(p.mul(r, r), polynomial(p, r, kExp), p.mul_add(r_error, r, r_error));
  return {n, r, tail};
}

LowId clamp(ProgramBuilder& p, LowId x, double low, double high) {
  // The order of operands lets a NaN in x through.
  return p.emit(Code::Min, p.constant(high), p.emit(Code::Max, p.constant(low), x));
}

LowId exp_of_pair(ProgramBuilder& p, LowId x, LowId x_low) {
  const ExpReduction e = reduce_exp(p, clamp(p, x, -746.0, 710.0), x_low);
  const Pair sum = fast_two_sum(p, p.constant(1.0), e.r);
  return scale(p, p.add(sum.high, p.add(sum.low, e.tail)), e.n);
}

// x = 2^k m with m in [sqrt(1/2), sqrt(2)) for positive finite x, also subnormal.
struct LogReduction {
  LowId k, m;
};
LogReduction reduce_log(ProgramBuilder& p, LowId x) {
  constexpr uint64_t kOne = 0x3ff0000000000000ull, kSqrtHalf = 0x3fe6a09e667f3bcdull;
  const LowId tiny = p.emit(Code::Less, x, p.constant(0x1p-1022));
  const LowId normal = p.select(tiny, p.mul(x, p.constant(0x1p54)), x);
  const LowId u = p.emit(Code::AddInt, normal, p.bits(kOne - kSqrtHalf));
  const LowId exponent = p.emit(Code::ShiftRight, u, -1, -1, 52);
  const LowId biased = p.emit(Code::Or, exponent, p.constant(0x1p52));
  const LowId bias = p.select(tiny, p.constant(0x1p52 + 1023.0 + 54.0), p.constant(0x1p52 + 1023.0));
  const LowId mantissa = p.emit(Code::And, u, p.bits(0x000fffffffffffffull));
  return {p.sub(biased, bias), p.emit(Code::AddInt, mantissa, p.bits(kSqrtHalf))};
}

// Result for every x from the result for positive finite x.
LowId finish_log(ProgramBuilder& p, LowId x, LowId result) {
  const LowId zero = p.constant(0.0);
  const LowId finite = p.emit(Code::Less, x, p.constant(kInfinity));
  const LowId special =
      p.select(p.emit(Code::LessEqual, zero, x), p.constant(-kInfinity), p.bits(0x7ff8000000000000ull));
  return p.select(p.emit(Code::Less, zero, x), p.select(finite, result, x), special);
}

// log x for positive finite x with about 65 correct bits: 2 s + 2/3 s^3 in pairs, the rest in one double.
Pair log_pair(ProgramBuilder& p, LowId x) {
  const auto [k, m] = reduce_log(p, x);
  const LowId one = p.constant(1.0);
  const LowId f = p.sub(m, one);
  const LowId d = p.add(m, one), d_low = p.sub(m, p.sub(d, one));
  const LowId s = p.div(f, d);
  const LowId s_low = p.div(p.neg_mul_add(s, d_low, p.neg_mul_add(s, d, f)), d);
  const Pair z = two_product(p, s, s);
  const LowId z_low = p.mul_add(p.add(s, s), s_low, z.low);
  const Pair c = two_product(p, z.high, s);
  const LowId c_low = p.add(c.low, p.mul_add(z_low, s, p.mul(z.high, s_low)));
  const LowId third = p.constant(0x1.5555555555555p-1), third_low = p.constant(0x1.5555555555555p-55);
  const Pair q = two_product(p, c.high, third);
  const LowId q_low = p.add(q.low, p.mul_add(c.high, third_low, p.mul(c_low, third)));
  const LowId rest = p.mul(p.mul(c.high, z.high), polynomial(p, z.high, kPow));
  const Pair a = two_sum(p, p.mul(k, p.constant(kLn2High)), p.add(s, s));
  const Pair b = fast_two_sum(p, a.high, q.high);
  LowId low = p.add(p.add(a.low, b.low), p.add(p.add(s_low, s_low), p.add(q_low, rest)));
  low = p.mul_add(k, p.constant(kLn2Low), low);
  return fast_two_sum(p, b.high, low);
}

/// Largest angle that has a sine.
constexpr double kLargestAngle = 0x1p51;

// x = n pi/2 + r + r_low; sine and cosine of the reduced angle and the integer n in the low bits of
// `quadrant`.
struct Trigonometric {
  LowId sine, cosine, quadrant;
};
Trigonometric reduce_trigonometric(ProgramBuilder& p, LowId number) {
  // Beyond it n has no room for a quadrant.
  const LowId is_known = p.emit(Code::LessEqual, absolute(p, number), p.constant(kLargestAngle));
  const LowId x = p.select(is_known, number, p.constant(std::numeric_limits<double>::quiet_NaN()));
  const LowId n = p.emit(Code::Round, p.mul(x, p.constant(0x1.45f306dc9c883p-1)));
  const LowId r0 = p.neg_mul_add(n, p.constant(kHalfPi1), x);
  const Pair second = two_product(p, n, p.constant(kHalfPi2));
  const LowId r = p.sub(r0, second.high);
  const LowId rounding = p.sub(p.sub(p.sub(r0, r), second.high), second.low);
  const LowId low = p.neg_mul_add(n, p.constant(kHalfPi3), rounding);
  const LowId z = p.mul(r, r), half = p.mul(p.constant(0.5), z), one = p.constant(1.0);
  const LowId s = p.mul_add(p.mul(r, z), polynomial(p, z, kSin), p.neg_mul_add(half, low, low));
  const LowId w = p.sub(one, half);
  const LowId c =
      p.mul_add(p.mul(z, z), polynomial(p, z, kCos), p.neg_mul_add(r, low, p.sub(p.sub(one, w), half)));
  return {p.add(r, s), p.add(w, c), p.add(n, p.constant(0x1.8p52))};
}
LowId odd_mask(ProgramBuilder& p, LowId quadrant) {
  return p.emit(Code::SubInt, p.bits(0), p.emit(Code::And, quadrant, p.bits(1)));
}
LowId half_turn_sign(ProgramBuilder& p, LowId quadrant) {
  return p.emit(Code::ShiftLeft, p.emit(Code::And, quadrant, p.bits(2)), -1, -1, 62);
}

// asin of |x|: small = |x| <= 1/2; s and tail with asin = s + tail (small) or pi/2 - 2 (s + tail).
struct ArcReduction {
  LowId small, s, tail;
};
ArcReduction reduce_arc(ProgramBuilder& p, LowId x) {
  const LowId a = absolute(p, x);
  const LowId small = p.emit(Code::LessEqual, a, p.constant(0.5));
  const LowId z = p.select(small, p.mul(a, a), p.neg_mul_add(p.constant(0.5), a, p.constant(0.5)));
  const LowId s = p.select(small, a, p.emit(Code::Sqrt, z));
  return {small, s, p.mul(p.mul(s, z), polynomial(p, z, kAsin))};
}

// Angle of (x, y) in [0, pi/2] for x, y >= 0, as high + low: the point is turned by 0, 45 or 90 degrees
// first.
Pair first_quadrant_angle(ProgramBuilder& p, LowId y, LowId x) {
  const LowId steep = p.emit(Code::Less, p.mul(p.constant(0x1.3504f333f9de6p+1), x), y);
  const LowId flat = p.emit(Code::LessEqual, y, p.mul(p.constant(0x1.a827999fcef32p-2), x));
  LowId numerator = p.select(flat, y, p.sub(y, x));
  LowId denominator = p.select(flat, x, p.add(x, y));
  numerator = p.select(steep, p.negate(x), numerator);
  denominator = p.select(steep, y, denominator);
  const LowId zero = p.constant(0.0);
  denominator = p.select(p.emit(Code::LessEqual, denominator, zero), p.constant(1.0), denominator);
  const LowId t = p.div(numerator, denominator), z = p.mul(t, t);
  const LowId high = p.select(steep, p.constant(kHalfPi1), p.select(flat, zero, p.constant(0.5 * kHalfPi1)));
  const LowId low = p.select(steep, p.constant(kHalfPi2), p.select(flat, zero, p.constant(0.5 * kHalfPi2)));
  const LowId tail = p.mul_add(p.mul(t, z), polynomial(p, z, kAtan), low);
  // high + t: exact up to an error that joins the tail (|t| < high or high = 0).
  const LowId sum = p.add(high, t);
  return {sum, p.add(p.sub(t, p.sub(sum, high)), tail)};
}

}  // namespace

LowId expand_exp(ProgramBuilder& p, LowId x) { return exp_of_pair(p, x, -1); }

LowId expand_log(ProgramBuilder& p, LowId x) {
  // log(1 + f) = f - (f^2/2 - s (f^2/2 + R(s^2))), s = f / (2 + f).
  const auto [k, m] = reduce_log(p, x);
  const LowId f = p.sub(m, p.constant(1.0));
  const LowId s = p.div(f, p.add(f, p.constant(2.0)));
  const LowId z = p.mul(s, s), half = p.mul(p.mul(p.constant(0.5), f), f);
  const LowId R = p.mul_add(z, polynomial(p, z, kLog), half);
  const LowId correction = p.mul_add(s, R, p.mul(k, p.constant(kLn2Low)));
  const LowId result = p.mul_add(k, p.constant(kLn2High), p.sub(f, p.sub(half, correction)));
  return finish_log(p, x, result);
}

LowId expand_sin(ProgramBuilder& p, LowId x) {
  const auto [sine, cosine, quadrant] = reduce_trigonometric(p, x);
  return with_sign(p, p.select(odd_mask(p, quadrant), cosine, sine), half_turn_sign(p, quadrant));
}

LowId expand_cos(ProgramBuilder& p, LowId x) {
  const auto [sine, cosine, quadrant] = reduce_trigonometric(p, x);
  const LowId next = p.emit(Code::AddInt, quadrant, p.bits(1));
  return with_sign(p, p.select(odd_mask(p, quadrant), sine, cosine), half_turn_sign(p, next));
}

LowId expand_tan(ProgramBuilder& p, LowId x) {
  const auto [sine, cosine, quadrant] = reduce_trigonometric(p, x);
  const LowId odd = odd_mask(p, quadrant);
  const LowId ratio = p.div(p.select(odd, cosine, sine), p.select(odd, sine, cosine));
  return with_sign(p, ratio, p.emit(Code::And, odd, p.bits(kSignBit)));
}

LowId expand_asin(ProgramBuilder& p, LowId x) {
  const auto [small, s, tail] = reduce_arc(p, x);
  const LowId two = p.constant(2.0);
  const LowId large =
      p.add(p.neg_mul_add(two, s, p.constant(kHalfPi1)), p.neg_mul_add(two, tail, p.constant(kHalfPi2)));
  return with_sign(p, p.select(small, p.add(s, tail), large), sign_of(p, x));
}

LowId expand_acos(ProgramBuilder& p, LowId x) {
  const auto [small, s, tail] = reduce_arc(p, x);
  const LowId sign = sign_of(p, x), two = p.constant(2.0);
  // |x| <= 1/2: pi/2 - asin x. Else: x > 0: 2 (s + tail); x < 0: pi - 2 (s + tail).
  const LowId middle =
      p.sub(p.constant(kHalfPi1), p.sub(with_sign(p, p.add(s, tail), sign), p.constant(kHalfPi2)));
  const LowId twice = p.mul(two, p.add(s, tail));
  const LowId turned = p.add(p.neg_mul_add(two, s, p.constant(2.0 * kHalfPi1)),
                             p.neg_mul_add(two, tail, p.constant(2.0 * kHalfPi2)));
  const LowId negative = p.emit(Code::Less, x, p.constant(0.0));
  return p.select(small, middle, p.select(negative, turned, twice));
}

LowId expand_atan(ProgramBuilder& p, LowId x) {
  const Pair angle = first_quadrant_angle(p, absolute(p, x), p.constant(1.0));
  return with_sign(p, p.add(angle.high, angle.low), sign_of(p, x));
}

LowId expand_atan2(ProgramBuilder& p, LowId y, LowId x) {
  const Pair angle = first_quadrant_angle(p, absolute(p, y), absolute(p, x));
  const LowId left = p.emit(Code::Less, p.emit(Code::Or, sign_of(p, x), p.constant(1.0)), p.constant(0.0));
  // pi - angle keeps the small parts apart until the last addition.
  const Pair turned = fast_two_sum(p, p.constant(2.0 * kHalfPi1), p.negate(angle.high));
  const LowId turned_low = p.add(turned.low, p.sub(p.constant(2.0 * kHalfPi2), angle.low));
  const LowId result = p.add(p.select(left, turned.high, angle.high), p.select(left, turned_low, angle.low));
  return with_sign(p, result, sign_of(p, y));
}

LowId expand_tanh(ProgramBuilder& p, LowId x) {
  // tanh |x| = e / (e + 2) with e = exp(2 |x|) - 1; beyond 22 the result rounds to 1.
  const LowId a = p.emit(Code::Min, p.constant(22.0), absolute(p, x));
  const ExpReduction r = reduce_exp(p, p.add(a, a), -1);
  const LowId power = power_of_two(p, r.n);
  const LowId small = p.sub(power, p.constant(1.0));
  const LowId e = p.add(p.mul_add(power, r.r, small), p.mul(power, r.tail));
  return with_sign(p, p.div(e, p.add(e, p.constant(2.0))), sign_of(p, x));
}

LowId expand_pow(ProgramBuilder& p, LowId x, LowId y) {
  const Pair l = log_pair(p, x);
  const LowId zero = p.constant(0.0), one = p.constant(1.0);
  const LowId e = p.mul(y, l.high);
  LowId low = p.mul_add(y, l.low, p.mul_sub(y, l.high, e));
  low = p.select(p.emit(Code::Less, absolute(p, e), p.constant(800.0)), low, zero);
  LowId result = exp_of_pair(p, e, low);
  // 0 and infinity, by the sign of the exponent; then negative bases and NaN.
  const LowId growing = p.emit(Code::Less, zero, y), falling = p.emit(Code::Less, y, zero);
  const LowId at_zero = p.select(growing, zero, p.select(falling, p.constant(kInfinity), one));
  const LowId at_infinity = p.select(growing, p.constant(kInfinity), p.select(falling, zero, one));
  result = p.select(p.emit(Code::Less, x, p.constant(kInfinity)), result, at_infinity);
  result = p.select(p.emit(Code::Less, zero, x), result, at_zero);
  result = p.select(p.emit(Code::LessEqual, zero, x), result, p.bits(0x7ff8000000000000ull));
  return p.select(p.emit(Code::LessEqual, y, y), result, y);
}

}  // namespace stark::symbolic
