/* The reference for speed: one RK4 step of the 6-DoF vehicle in plain C, as written by hand.
 *
 * Same mathematics as src/vehicle: full 6 x 6 matrices, eight thrusters with rotor lag and the
 * quadratic thrust curve, current, quaternion with the drift term. Coefficients are derived by the
 * caller. Build with -O3; nothing here is tuned to a machine.
 *
 * State: p_ned[3], quaternion[4] (w x y z), nu[6], rotor speed[8]; SI, NED and FRD.
 */
#include <math.h>
#include <string.h>

enum { N = 21 };

typedef struct {
    double mass, weight, buoyancy, rotor_rate, thrust_gain, thrust_limit;
    double centre_of_buoyancy[3];
    double inertia[3][3];
    double added_mass[6][6];
    double mass_inverse[6][6];
    double linear_damping[6], quadratic_damping[6];
    double thruster_wrench[8][6];
} rexrov_parameters;

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void rotation(const double q[4], double r[3][3])
{
    double w = q[0], x = q[1], y = q[2], z = q[3];
    double s = 2.0 / (w * w + x * x + y * y + z * z);
    r[0][0] = 1.0 - s * (y * y + z * z);
    r[0][1] = s * (x * y - w * z);
    r[0][2] = s * (x * z + w * y);
    r[1][0] = s * (x * y + w * z);
    r[1][1] = 1.0 - s * (x * x + z * z);
    r[1][2] = s * (y * z - w * x);
    r[2][0] = s * (x * z - w * y);
    r[2][1] = s * (y * z + w * x);
    r[2][2] = 1.0 - s * (x * x + y * y);
}

static void acceleration(const rexrov_parameters *p, const double *state, double r[3][3],
                         const double wrench[6], const double current_ned[3], double out[6])
{
    const double *v = state + 7, *omega = state + 10, *rotor = state + 13;
    double current[3], nu_r[6], momentum[6], turn[3], a[3], b[3], c[3], h[3], tau[6];
    for (int i = 0; i < 3; i++) {
        current[i] = r[0][i] * current_ned[0] + r[1][i] * current_ned[1] + r[2][i] * current_ned[2];
        nu_r[i] = v[i] - current[i];
        nu_r[3 + i] = omega[i];
    }
    for (int i = 0; i < 6; i++) {
        momentum[i] = 0.0;
        for (int j = 0; j < 6; j++)
            momentum[i] += p->added_mass[i][j] * nu_r[j];
    }
    memcpy(tau, wrench, sizeof tau);
    for (int k = 0; k < 8; k++) {
        double thrust = p->thrust_gain * rotor[k] * fabs(rotor[k]);
        for (int i = 0; i < 6; i++)
            tau[i] += p->thruster_wrench[k][i] * thrust;
    }
    cross(omega, v, a);
    cross(omega, momentum, b);
    for (int i = 0; i < 3; i++)
        tau[i] += (p->weight - p->buoyancy) * r[2][i] - p->mass * a[i] - b[i];
    for (int i = 0; i < 3; i++)
        h[i] = p->inertia[i][0] * omega[0] + p->inertia[i][1] * omega[1]
             + p->inertia[i][2] * omega[2] + momentum[3 + i];
    cross(omega, h, a);
    cross(nu_r, momentum, b);
    cross(p->centre_of_buoyancy, r[2], c);
    for (int i = 0; i < 3; i++)
        tau[3 + i] -= a[i] + b[i] + p->buoyancy * c[i];
    cross(omega, current, turn);
    for (int i = 0; i < 6; i++) {
        tau[i] -= p->added_mass[i][0] * turn[0] + p->added_mass[i][1] * turn[1]
                + p->added_mass[i][2] * turn[2];
        tau[i] -= (p->linear_damping[i] + p->quadratic_damping[i] * fabs(nu_r[i])) * nu_r[i];
    }
    for (int i = 0; i < 6; i++) {
        out[i] = 0.0;
        for (int j = 0; j < 6; j++)
            out[i] += p->mass_inverse[i][j] * tau[j];
    }
}

static void derivative(const rexrov_parameters *p, const double *x, const double target[8],
                       const double wrench[6], const double current_ned[3], double *dx)
{
    double r[3][3];
    const double *q = x + 3, *nu = x + 7;
    rotation(q, r);
    for (int i = 0; i < 3; i++)
        dx[i] = r[i][0] * nu[0] + r[i][1] * nu[1] + r[i][2] * nu[2];
    double stretch = 0.5 * (1.0 - (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]));
    dx[3] = 0.5 * (-q[1] * nu[3] - q[2] * nu[4] - q[3] * nu[5]) + stretch * q[0];
    dx[4] = 0.5 * (q[0] * nu[3] + q[2] * nu[5] - q[3] * nu[4]) + stretch * q[1];
    dx[5] = 0.5 * (q[0] * nu[4] + q[3] * nu[3] - q[1] * nu[5]) + stretch * q[2];
    dx[6] = 0.5 * (q[0] * nu[5] + q[1] * nu[4] - q[2] * nu[3]) + stretch * q[3];
    acceleration(p, x, r, wrench, current_ned, dx + 7);
    for (int i = 0; i < 8; i++)
        dx[13 + i] = (target[i] - x[13 + i]) * p->rotor_rate;
}

/* Advances `x` by `h` seconds under commanded thrusts (N), a wrench and a current. */
void rexrov_rk4(const rexrov_parameters *p, double x[N], const double force[8],
                const double wrench[6], const double current_ned[3], double h)
{
    double target[8], k1[N], k2[N], k3[N], k4[N], stage[N];
    for (int i = 0; i < 8; i++) {
        double f = fmax(-p->thrust_limit, fmin(p->thrust_limit, force[i]));
        target[i] = copysign(sqrt(fabs(f) / p->thrust_gain), f);
    }
    derivative(p, x, target, wrench, current_ned, k1);
    for (int i = 0; i < N; i++)
        stage[i] = x[i] + 0.5 * h * k1[i];
    derivative(p, stage, target, wrench, current_ned, k2);
    for (int i = 0; i < N; i++)
        stage[i] = x[i] + 0.5 * h * k2[i];
    derivative(p, stage, target, wrench, current_ned, k3);
    for (int i = 0; i < N; i++)
        stage[i] = x[i] + h * k3[i];
    derivative(p, stage, target, wrench, current_ned, k4);
    for (int i = 0; i < N; i++)
        x[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
}

#ifdef REXROV_MAIN
/* Stand-alone reference: reads, as binary doubles, the parameters, state, force, wrench, current,
 * step size and number of steps; writes nanoseconds per step and the final state as text. */
#include <stdio.h>
#include <time.h>

int main(void)
{
    static rexrov_parameters p;
    double x[N], force[8], wrench[6], current[3], h, steps;
    if (fread(&p, sizeof p, 1, stdin) != 1 || fread(x, sizeof x, 1, stdin) != 1
        || fread(force, sizeof force, 1, stdin) != 1 || fread(wrench, sizeof wrench, 1, stdin) != 1
        || fread(current, sizeof current, 1, stdin) != 1 || fread(&h, sizeof h, 1, stdin) != 1
        || fread(&steps, sizeof steps, 1, stdin) != 1) {
        fprintf(stderr, "rexrov: input too short\n");
        return 1;
    }
    struct timespec a, b;
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (long i = 0; i < (long)steps; i++)
        rexrov_rk4(&p, x, force, wrench, current, h);
    clock_gettime(CLOCK_MONOTONIC, &b);
    printf("%.3f\n", ((double)(b.tv_sec - a.tv_sec) * 1e9 + (double)(b.tv_nsec - a.tv_nsec)) / steps);
    for (int i = 0; i < N; i++)
        printf("%.17g\n", x[i]);
    return 0;
}
#endif
