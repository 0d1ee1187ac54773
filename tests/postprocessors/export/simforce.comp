/* Six force sensors that carry a rigid platform, for tests: an implementation of its own, from Newton and Euler, of what
 * they read while LinuxCNC moves it. TRUTH is replaced: mass, first moments, inertia (6), offsets (6), k0, k1, k2, k3;
 * JT by J^T, row by row; PUSH by force and moment that act on the platform while the pin push is true. */
component simforce "Simulated force sensors";
pin in float pose-#[6] "commanded pose [mm, degrees]";
pin in bit push;
pin out float force-#[6] "N";
param rw float noise = 1.0 "standard deviation [N]";
function _ fp;
variable double past[18];
variable double late[48];
variable unsigned state = 1;
variable int cycles;
license "GPL";
;;
#include <rtapi_math.h>

static const double truth[] = { TRUTH };
static const double jt[36] = { JT };
static const double pushed[6] = { PUSH };

#define EXTRA 3 /* cycles, beside the one that the central difference takes, by which the sensors are late */

static double gaussian(unsigned *number)
{
    double sum = -6.0;
    int k;

    for (k = 0; k < 12; k++) {
        *number = *number * 1664525u + 1013904223u;
        sum += *number / 4294967296.0;
    }
    return sum;
}

static void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static void into(double r[3][3], const double *base, double *platform)
{
    int i;

    for (i = 0; i < 3; i++)
        platform[i] = r[0][i] * base[0] + r[1][i] * base[1] + r[2][i] * base[2];
}

static void wrench_of(const double *p, const double *v, const double *a, double *w)
{
    double m = truth[0], sr = sin(p[3]), cr = cos(p[3]), sp = sin(p[4]), cp = cos(p[4]), sy = sin(p[5]), cy = cos(p[5]);
    double r[3][3] = { { cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr },
                       { sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr },
                       { -sp, cp * sr, cp * cr } };
    double roll_axis[3] = { cy * cp, sy * cp, -sp }, pitch_axis[3] = { -sy, cy, 0.0 };
    double carried[3], turned[3], omega[3], alpha[3], lifted[3], om[3], al[3], ac[3], one[3], two[3], mom[3];
    double trace = r[0][0] + r[1][1] + r[2][2];
    double gx = (r[2][1] - r[1][2]) / (1.0 + trace), gy = (r[0][2] - r[2][0]) / (1.0 + trace);
    const double *first = truth + 1, *i = truth + 4, *k = truth + 16;
    int j;

    for (j = 0; j < 3; j++) {
        carried[j] = v[4] * pitch_axis[j] + (j == 2 ? v[5] : 0.0);
        omega[j] = carried[j] + v[3] * roll_axis[j];
    }
    cross(carried, roll_axis, turned);
    for (j = 0; j < 3; j++)
        alpha[j] = a[3] * roll_axis[j] + a[4] * pitch_axis[j] + (j == 2 ? a[5] : 0.0) + v[3] * turned[j];
    alpha[0] -= v[4] * v[5] * cy;
    alpha[1] -= v[4] * v[5] * sy;
    lifted[0] = a[0];
    lifted[1] = a[1];
    lifted[2] = a[2] + 9.81;
    into(r, omega, om);
    into(r, alpha, al);
    into(r, lifted, ac);
    cross(al, first, one);
    cross(om, first, two);
    cross(om, two, turned);
    for (j = 0; j < 3; j++)
        w[j] = m * ac[j] + one[j] + turned[j];
    cross(first, ac, one);
    mom[0] = i[0] * om[0] + i[1] * om[1] + i[2] * om[2];
    mom[1] = i[1] * om[0] + i[3] * om[1] + i[4] * om[2];
    mom[2] = i[2] * om[0] + i[4] * om[1] + i[5] * om[2];
    cross(om, mom, two);
    w[3] = one[0] + two[0] + i[0] * al[0] + i[1] * al[1] + i[2] * al[2];
    w[4] = one[1] + two[1] + i[1] * al[0] + i[3] * al[1] + i[4] * al[2];
    w[5] = one[2] + two[2] + i[2] * al[0] + i[4] * al[1] + i[5] * al[2];
    w[0] += k[0] * p[0] - k[2] * gy;
    w[1] += k[0] * p[1] + k[2] * gx;
    w[3] += k[1] * p[1] + k[3] * gx;
    w[4] += -k[1] * p[0] + k[3] * gy;
}

FUNCTION(_) {
    double dt = period * 1e-9, v[6], a[6], w[6], f;
    int j, n;

    for (j = 0; j < 6; j++) {
        past[12 + j] = past[6 + j];
        past[6 + j] = past[j];
        past[j] = pose(j) * (j < 3 ? 1e-3 : 0.017453292519943295);
    }
    if (cycles < 3) {
        cycles++;
        return;
    }
    for (j = 0; j < 6; j++) {
        v[j] = (past[j] - past[12 + j]) / (2.0 * dt);
        a[j] = (past[j] - 2.0 * past[6 + j] + past[12 + j]) / (dt * dt);
    }
    wrench_of(past + 6, v, a, w);
    for (j = 0; push && j < 6; j++)
        w[j] -= pushed[j];
    for (j = 0; j < 6; j++) {
        f = truth[10 + j] + noise * gaussian(&state);
        for (n = 0; n < 6; n++)
            f += jt[6 * j + n] * w[n];
        for (n = EXTRA; n > 0; n--)
            late[8 * j + n] = late[8 * j + n - 1];
        late[8 * j] = f;
        force(j) = late[8 * j + EXTRA];
    }
}
