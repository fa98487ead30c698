/* The accelerations of three joints under soft constraints.

   The acceleration a minimises ½ aᵀB a - bᵀa + Σ s_i(J_i a - r_i) with s_i(z) = ½ w_i z² on one side of zero
   for a stop or a surface, and for friction with the slope ±loss_i beyond |z| = loss_i/w_i. The minimum is found
   by Newton's method with an exact line search: the cost is convex and piecewise quadratic, so that the search
   ends after a few steps at the exact minimum. Whatever the first guess, its bits are those of the system of
   equations in the zones where the minimum lies.

   Source: MuJoCo documentation, Computation, Constraint model and Solver. */

#define PRP_ROWS 7 /* friction (3), joint stops (3), surface (1) */
#define PRP_FRICTION_ROW 0
#define PRP_STOP_ROW 3
#define PRP_SURFACE_ROW 6
#define PRP_MOST_STEPS 100
#define PRP_WHOLE_STEPS 1 /* first steps without a line search, which takes longer than a further step */

typedef struct {
    int count;
    double jacobian[PRP_ROWS][3], reference[PRP_ROWS], weight[PRP_ROWS];
    double loss[PRP_ROWS]; /* of friction; negative for a constraint with one side */
    double force[PRP_ROWS];
    int row[PRP_ROWS]; /* PRP_FRICTION_ROW + joint, PRP_STOP_ROW + joint or PRP_SURFACE_ROW */
} prp_constraints;

static inline double prp_dot3(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Add a constraint; `loss` is negative for one with one side. */
static inline void prp_add(
    prp_constraints *c, int row, const double *jacobian, double reference, double weight, double loss)
{
    const int n = c->count++;
    c->row[n] = row;
    for (int j = 0; j < 3; j++)
        c->jacobian[n][j] = jacobian[j];
    c->reference[n] = reference, c->weight[n] = weight, c->loss[n] = loss;
}

/* The force of a constraint at z = J a - r; `stiff` is set to -d force/dz. */
static inline double prp_force(const prp_constraints *c, int i, double z, double *stiff)
{
    const double spring = -c->weight[i] * z;
    *stiff = c->weight[i];
    if (c->loss[i] < 0.0) {
        if (z < 0.0)
            return spring;
        *stiff = 0.0;
        return 0.0;
    }
    if (spring > c->loss[i] || spring < -c->loss[i]) {
        *stiff = 0.0;
        return spring > 0.0 ? c->loss[i] : -c->loss[i];
    }
    return spring;
}

/* Slope and curvature of the cost along a line, at the share t of a step. */
static inline double prp_slope(
    const prp_constraints *c, const double *z, const double *move, double linear, double square, double t,
    double *curvature)
{
    double slope = linear + square * t;
    *curvature = square;
    for (int i = 0; i < c->count; i++) {
        double stiff;
        const double force = prp_force(c, i, z[i] + t * move[i], &stiff);
        slope -= force * move[i];
        *curvature += stiff * move[i] * move[i];
    }
    return slope;
}

/* The share of a step at which the cost is least: the root of a slope that rises in straight pieces. */
static double prp_line_search(
    const prp_constraints *c, const double *z, const double *move, double linear, double square)
{
    double low = 0.0, high = INFINITY, t = 1.0;
    for (int k = 0; k < PRP_MOST_STEPS; k++) {
        double curvature;
        const double slope = prp_slope(c, z, move, linear, square, t, &curvature);
        if (slope == 0.0)
            return t;
        if (slope < 0.0)
            low = t;
        else
            high = t;
        const double next = t - slope / curvature;
        if (next == t)
            return t;
        t = next > low && next < high ? next : (high < INFINITY ? 0.5 * (low + high) : 2.0 * low + 1.0);
        if (t == low || t == high)
            return t;
    }
    return t;
}

/* The accelerations at which the cost would be least if every constraint stayed in its zone: in the curved one
   where it is stiff, else where its force is constant. They depend on the zones alone, not on the way to them. */
static inline void prp_stationary(
    const prp_constraints *c, const double B[9], const double b[3], const double *stiff, double a[3])
{
    double hessian[9], right[3];
    memcpy(hessian, B, sizeof hessian);
    memcpy(right, b, sizeof right);
    for (int i = 0; i < c->count; i++) {
        const double *J = c->jacobian[i];
        const double constant = stiff[i] != 0.0 ? stiff[i] * c->reference[i] : c->force[i];
        const double x = stiff[i] * J[0], y = stiff[i] * J[1], z = stiff[i] * J[2];
        right[0] += J[0] * constant, right[1] += J[1] * constant, right[2] += J[2] * constant;
        hessian[0] += x * J[0]; /* of which prp_solve3 reads the lower triangle */
        hessian[3] += y * J[0], hessian[4] += y * J[1];
        hessian[6] += z * J[0], hessian[7] += z * J[1], hessian[8] += z * J[2];
    }
    prp_solve3(hessian, right, a);
}

/* Go from `a` towards `next`, as far as the cost falls; returns the share of the way. */
static double prp_go(
    const prp_constraints *c, const double B[9], const double b[3], const double *z, const double *later,
    const double *next, double *a)
{
    double linear = 0.0, square = 0.0, direction[3], move[PRP_ROWS];
    for (int j = 0; j < 3; j++)
        direction[j] = next[j] - a[j];
    for (int j = 0; j < 3; j++) {
        const double moved = prp_dot3(B + 3 * j, direction);
        linear += moved * a[j] - b[j] * direction[j];
        square += moved * direction[j];
    }
    for (int i = 0; i < c->count; i++)
        move[i] = later[i] - z[i];
    const double t = prp_line_search(c, z, move, linear, square);
    for (int j = 0; j < 3; j++)
        a[j] += t * direction[j];
    return t;
}

/* The forces of the constraints at the accelerations `a`; returns whether all are in the zones in which they
   were, those of `c->force` and `stiff`. */
static inline int prp_set_forces(prp_constraints *c, const double *a, double *z, double *stiff)
{
    int same = 1;
    for (int i = 0; i < c->count; i++) {
        double slope;
        z[i] = prp_dot3(c->jacobian[i], a) - c->reference[i];
        const double force = prp_force(c, i, z[i], &slope);
        same &= slope == stiff[i] && (slope != 0.0 || force == c->force[i]);
        c->force[i] = force, stiff[i] = slope;
    }
    return same;
}

/* Minimise; `a` holds the first guess and then the accelerations, `c->force` the forces of the constraints. */
static void prp_minimise(prp_constraints *c, const double B[9], const double b[3], double a[3])
{
    double z[PRP_ROWS], stiff[PRP_ROWS] = {0.0}, t = 1.0;
    memset(c->force, 0, sizeof c->force);
    prp_set_forces(c, a, z, stiff);
    for (int step = 0; step < PRP_MOST_STEPS && t != 0.0; step++) {
        double next[3], later[PRP_ROWS];
        prp_stationary(c, B, b, stiff, next);
        const int same = prp_set_forces(c, next, later, stiff);
        if (same || step < PRP_WHOLE_STEPS) {
            memcpy(a, next, sizeof next), memcpy(z, later, sizeof z);
            if (same)
                return;
        } else {
            t = prp_go(c, B, b, z, later, next, a);
            prp_set_forces(c, a, z, stiff);
        }
    }
}
