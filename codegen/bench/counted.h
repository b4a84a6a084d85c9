/* A number that counts what is done with it (C++): generated C that is compiled with it tells its operations. Macro: NUMBER, float or double. */
#ifndef COUNTED_H
#define COUNTED_H
#include <math.h>

struct tally {
    long additions, multiplications, divisions, sqrt, sin, cos, atan2;
};
static tally counted;

struct number {
    NUMBER v;
    number() = default;
    number(int x) : v((NUMBER)x) {}
    number(unsigned int x) : v((NUMBER)x) {}
    number(float x) : v((NUMBER)x) {}
    number(double x) : v((NUMBER)x) {}
    explicit operator int() const { return (int)v; }
    explicit operator double() const { return (double)v; }
    number operator-() const { return number(-v); }
    number operator+() const { return *this; }
    number &operator+=(number b) { ++counted.additions; v += b.v; return *this; }
    number &operator-=(number b) { ++counted.additions; v -= b.v; return *this; }
    number &operator*=(number b) { ++counted.multiplications; v *= b.v; return *this; }
    number &operator/=(number b) { ++counted.divisions; v /= b.v; return *this; }
    friend number operator+(number a, number b) { return a += b; }
    friend number operator-(number a, number b) { return a -= b; }
    friend number operator*(number a, number b) { return a *= b; }
    friend number operator/(number a, number b) { return a /= b; }
    friend bool operator<(number a, number b) { return a.v < b.v; }
    friend bool operator>(number a, number b) { return a.v > b.v; }
    friend bool operator<=(number a, number b) { return a.v <= b.v; }
    friend bool operator>=(number a, number b) { return a.v >= b.v; }
    friend bool operator==(number a, number b) { return a.v == b.v; }
};

static inline number sqrt(number x) { ++counted.sqrt; return number((NUMBER)::sqrt((double)x.v)); }
static inline number sin(number x) { ++counted.sin; return number((NUMBER)::sin((double)x.v)); }
static inline number cos(number x) { ++counted.cos; return number((NUMBER)::cos((double)x.v)); }
static inline number atan2(number y, number x) { ++counted.atan2; return number((NUMBER)::atan2((double)y.v, (double)x.v)); }
static inline number fabs(number x) { return number((NUMBER)::fabs((double)x.v)); }
static inline number sqrtf(number x) { return sqrt(x); }
static inline number sinf(number x) { return sin(x); }
static inline number cosf(number x) { return cos(x); }
static inline number atan2f(number y, number x) { return atan2(y, x); }
static inline number fabsf(number x) { return fabs(x); }
static inline int isfinite(number x) { return (int)(x.v - x.v == (NUMBER)0); }
#endif
