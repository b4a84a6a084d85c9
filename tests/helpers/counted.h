/* A number that counts what is done with it (C++): generated C that is compiled with it tells its operations. Macro: NUMBER, float or double. */
#ifndef COUNTED_H
#define COUNTED_H
#include <math.h>

enum { ADDITIONS, MULTIPLICATIONS, DIVISIONS, SQRT, SIN, COS, ATAN2, OPERATIONS };
struct tally {
    unsigned int of[OPERATIONS] = {};
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
    number &operator+=(number b) { ++counted.of[ADDITIONS]; v += b.v; return *this; }
    number &operator-=(number b) { ++counted.of[ADDITIONS]; v -= b.v; return *this; }
    number &operator*=(number b) { ++counted.of[MULTIPLICATIONS]; v *= b.v; return *this; }
    number &operator/=(number b) { ++counted.of[DIVISIONS]; v /= b.v; return *this; }
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

#define COUNTED(function, kind)                                                                                                 \
    static inline number function(number x) { ++counted.of[kind]; return number((NUMBER)::function((double)x.v)); }             \
    static inline number function##f(number x) { return function(x); }
COUNTED(sqrt, SQRT)
COUNTED(sin, SIN)
COUNTED(cos, COS)
static inline number atan2(number y, number x) { ++counted.of[ATAN2]; return number((NUMBER)::atan2((double)y.v, (double)x.v)); }
static inline number atan2f(number y, number x) { return atan2(y, x); }
static inline number fabs(number x) { return number((NUMBER)::fabs((double)x.v)); }
static inline number fabsf(number x) { return fabs(x); }
static inline int isfinite(number x) { return (int)(x.v - x.v == (NUMBER)0); }
#endif
