"""`scoring_of`: how policies on a task are shown in tables and audited."""

from prp_gym.tasks.spec import TASKS, TaskScoring


def scoring_of(environment_id: str) -> TaskScoring:
    """Columns of the tables and physical error of a task, as its declaration states them.

    Args:
        environment_id: id of an environment, declared or not.

    Returns:
        the declared scoring; one without columns and error where the task is not declared.
    """
    return TASKS[environment_id].scoring if environment_id in TASKS else TaskScoring()
