/* One iteration of iterative LQR for each of some plans, with the functions generated from the formulas. */

#define PRP_STATE (2 * PRP_JOINTS)
#define PRP_WEIGHTS (3 * PRP_JOINTS)

/* The problem of one plan; arrays of PRP_KNOTS rows, but for the state at the start. */
typedef struct {
    const double *state, *duration, *desired, *weight, *threshold, *effort, *effort_weight, *stops, *stop_weight;
    const double *low, *high;
} prp_problem;

/* A plan: its torques, and the states at the ends of its intervals. */
typedef struct {
    double torque[PRP_KNOTS][PRP_JOINTS], state[PRP_KNOTS][PRP_STATE];
} prp_plan;

/* How torques change with a step of size 1, and with the state at the start of an interval. */
typedef struct {
    double change[PRP_KNOTS][PRP_JOINTS], gain[PRP_KNOTS][PRP_JOINTS * PRP_STATE];
} prp_step;

static const double PRP_NO_STEP = 0.0, PRP_SHARES[] = {1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125};

/* The forward pass: a new plan from an old one and a share of a step; returns its cost. */
static double prp_forward(
    const prp_problem *problem, const prp_plan *old, const prp_step *step, const double *share, prp_plan *plan)
{
    double total = 0.0;
    const double *now = problem->state, *before = problem->state;
    for (int k = 0; k < PRP_KNOTS; k++) {
        const int joint = k * PRP_JOINTS;
        double deviation[PRP_STATE], cost, *later = plan->state[k];
        for (int i = 0; i < PRP_STATE; i++)
            deviation[i] = now[i] - before[i];
        prp_follow(
            old->torque[k], step->change[k], step->gain[k], share, deviation, problem->low + joint,
            problem->high + joint, plan->torque[k]);
        prp_motion(
            now, now + PRP_JOINTS, plan->torque[k], problem->duration + k, later, later + PRP_JOINTS);
        prp_cost(
            later, later + PRP_JOINTS, plan->torque[k], problem->desired + k * PRP_STATE,
            problem->weight + k * PRP_WEIGHTS, problem->threshold + joint, problem->effort + joint,
            problem->effort_weight + joint, problem->stops + k * PRP_STATE, problem->stop_weight + joint, &cost);
        total = total + cost;
        now = later, before = old->state[k];
    }
    return total;
}

/* The backward pass: the step from a plan. */
static void prp_improving_step(const prp_problem *problem, const prp_plan *plan, prp_step *step)
{
    double slope[2][PRP_STATE], curvature[2][PRP_STATE * PRP_STATE];
    memset(slope, 0, sizeof slope), memset(curvature, 0, sizeof curvature);
    for (int k = PRP_KNOTS - 1; k >= 0; k--) {
        const int joint = k * PRP_JOINTS, from = (k + 1) % 2, to = k % 2;
        const double *now = k ? plan->state[k - 1] : problem->state, *later = plan->state[k];
        double by_position[PRP_JOINTS * PRP_JOINTS], by_velocity[PRP_JOINTS * PRP_JOINTS];
        double by_torque[PRP_JOINTS * PRP_JOINTS];
        prp_motion_derivatives(
            now, now + PRP_JOINTS, plan->torque[k], problem->duration + k, by_position, by_velocity, by_torque);
        prp_backward(
            later, later + PRP_JOINTS, plan->torque[k], by_position, by_velocity, by_torque,
            problem->duration + k, slope[from], curvature[from], problem->low + joint, problem->high + joint,
            problem->desired + k * PRP_STATE, problem->weight + k * PRP_WEIGHTS, problem->threshold + joint,
            problem->effort + joint, problem->effort_weight + joint, problem->stops + k * PRP_STATE,
            problem->stop_weight + joint, step->change[k], step->gain[k], slope[to], curvature[to]);
    }
}

/* Improve plans (count, PRP_KNOTS, PRP_JOINTS); expected: the state (count, PRP_STATE) after their first
 * interval; cost: before and after (count, 2). Durations, effort
 * weights, stops and stop weights are those of all plans. */
void prp_improve(
    long count, const double *state, const double *duration, const double *desired, const double *weight,
    const double *threshold, const double *effort, const double *effort_weight, const double *stops,
    const double *stop_weight, const double *low, const double *high, double *restrict torque,
    double *restrict expected, double *restrict cost)
{
    const prp_step still = {0};
    for (long row = 0; row < count; row++) {
        const long first = row * PRP_KNOTS, joint = first * PRP_JOINTS;
        const prp_problem problem = {
            state + row * PRP_STATE, duration, desired + first * PRP_STATE, weight + first * PRP_WEIGHTS,
            threshold + joint, effort + joint, effort_weight, stops, stop_weight, low + joint, high + joint};
        prp_plan given, plans[2];
        prp_step step;
        const prp_plan *best = plans;
        memcpy(given.torque, torque + joint, sizeof given.torque);
        memset(given.state, 0, sizeof given.state);
        double least = prp_forward(&problem, &given, &still, &PRP_NO_STEP, plans);
        cost[2 * row] = least;
        prp_improving_step(&problem, plans, &step);
        for (int trial = 0; trial < (int)(sizeof PRP_SHARES / sizeof *PRP_SHARES) && best == plans; trial++) {
            const double found = prp_forward(&problem, plans, &step, PRP_SHARES + trial, plans + 1);
            if (found < least)
                best = plans + 1, least = found;
        }
        cost[2 * row + 1] = least;
        memcpy(torque + joint, best->torque, sizeof best->torque);
        memcpy(expected + row * PRP_STATE, best->state[0], sizeof best->state[0]);
    }
}
