#if defined(__GNUC__)
#define MAYBE_UNUSED __attribute__((unused))
#define SEPARATE __attribute__((noinline))
#elif defined(_MSC_VER)
#define MAYBE_UNUSED
#define SEPARATE __declspec(noinline)
#else
#define MAYBE_UNUSED
#define SEPARATE
#endif

/* Unlike fmax and fmin, these return NaN if an argument is NaN. */
MAYBE_UNUSED static inline double larger_(double a, double b) { return (a > b || a != a) ? a : b; }
MAYBE_UNUSED static inline double smaller_(double a, double b) { return (a < b || a != a) ? a : b; }
MAYBE_UNUSED static inline int64_t larger_int_(int64_t a, int64_t b) { return a > b ? a : b; }
MAYBE_UNUSED static inline int64_t smaller_int_(int64_t a, int64_t b) { return a < b ? a : b; }
MAYBE_UNUSED static inline int64_t abs_int_(int64_t a) { return a < 0 ? -a : a; }
MAYBE_UNUSED static inline int64_t sign_int_(int64_t a) { return (a > 0) - (a < 0); }
MAYBE_UNUSED static inline double sign_(double a) { return a > 0 ? 1.0 : (a < 0 ? -1.0 : a); }
MAYBE_UNUSED static inline double square_(double a) { return a * a; }
MAYBE_UNUSED static inline int64_t square_int_(int64_t a) { return a * a; }
MAYBE_UNUSED static inline double clamp_(double low, double a, double high)
{
    return smaller_(larger_(a, low), high);
}
MAYBE_UNUSED static inline int64_t within_(int64_t a, int64_t most) { return a < 0 ? 0 : (a > most ? most : a); }
MAYBE_UNUSED static inline double integer_pow_(double a, int power)
{
    double result = 1.0;
    for (int n = power < 0 ? -power : power; n; n >>= 1, a *= a)
        if (n & 1) result *= a;
    return power < 0 ? 1.0 / result : result;
}
MAYBE_UNUSED static inline int64_t whole_pow_(int64_t a, int power)
{
    uint64_t result = 1, factor = (uint64_t)a;
    for (; power > 0; power >>= 1, factor *= factor)
        if (power & 1) result *= factor;
    return (int64_t)result;
}

/* Factors P A = L U of an (n, m) matrix in place, stored by rows, with partial pivoting. */
MAYBE_UNUSED static void lu_(double *a, int n, int m, int32_t *pivots, int32_t *order)
{
    for (int i = 0; i < n; ++i) order[i] = i;
    for (int k = 0; k < n && k < m; ++k) {
        int p = k;
        for (int i = k + 1; i < n; ++i)
            if (fabs(a[i * m + k]) > fabs(a[p * m + k])) p = i;
        pivots[k] = p;
        if (p != k) {
            const int32_t own = order[k];
            order[k] = order[p];
            order[p] = own;
            for (int j = 0; j < m; ++j) {
                const double entry = a[k * m + j];
                a[k * m + j] = a[p * m + j];
                a[p * m + j] = entry;
            }
        }
        const double *restrict row = a + k * m;
        const double inverse = row[k] == 0.0 ? 0.0 : 1.0 / row[k]; /* the entries below are zero too */
        for (int i = k + 1; i < n; ++i) {
            double *restrict other = a + i * m;
            const double factor = other[k] * inverse;
            other[k] = factor;
            for (int j = k + 1; j < m; ++j) other[j] -= factor * row[j];
        }
    }
}

/* Solves T X = B, (n, many), in place of B; T is triangular with entries a[across * i + along * j]. */
MAYBE_UNUSED static void triangular_(const double *a, int across, int along, double *b, int step, int next, int n,
                                     int many, int lower, int unit)
{
    for (int number = 0; number < n; ++number) {
        const int i = lower ? number : n - 1 - number;
        const double *row = a + across * i;
        double *own = b + step * i;
        for (int j = lower ? 0 : i + 1; j < (lower ? i : n); ++j) {
            const double factor = row[along * j];
            const double *known = b + step * j;
            for (int k = 0; k < many; ++k) own[next * k] -= factor * known[next * k];
        }
        if (!unit)
            for (int k = 0; k < many; ++k) own[next * k] /= row[along * i];
    }
}
