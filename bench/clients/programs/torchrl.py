"""TorchRL: one environment and several, with its check of the specifications and `info` in the tensors."""

from torchrl.collectors import SyncDataCollector
from torchrl.envs import GymEnv, check_env_specs
from torchrl.envs.gym_like import default_info_dict_reader

environment = GymEnv("prp_gym:PRP-Force-v0", scenario="report", duration=0.2)
environment.set_info_dict_reader(default_info_dict_reader())  # reads every number of `info`
environment.auto_register_info_dict()
check_env_specs(environment)

several = GymEnv("prp_gym:PRP-Force-v0", num_envs=2, scenario="report", duration=0.2)
check_env_specs(several)
collector = SyncDataCollector(several, frames_per_batch=400, total_frames=400)
for batch in collector:
    print(batch["next", "reward"].shape)
collector.shutdown()
