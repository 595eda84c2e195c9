// Asks the toshiba-mcu drive for its firmware version and, ten times a second, for the motor's state.
//
//   node state.mjs [PORT [COUNT]]        defaults: /tmp/drive, 10
import { once } from 'node:events';
import { SerialPort } from 'serialport';

const [path = '/tmp/drive', count = '10'] = process.argv.slice(2);
const MOTOR = 1;
const GET_MOTOR_STATE = 0x02;
const GET_VERSION = 0x14;
const ERROR = 0xee;
const PAYLOAD_BYTES = { [GET_MOTOR_STATE]: 20, [GET_VERSION]: 2, [ERROR]: 1 };

// CRC-8, polynomial 0x07; the command is the start value.
function crc8(command, payload) {
  let crc = command;
  for (const byte of payload) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) crc = crc & 0x80 ? ((crc << 1) ^ 0x107) & 0xff : crc << 1;
  }
  return crc;
}

const port = new SerialPort({ path, baudRate: 115200 });
let heard = Buffer.alloc(0);
port.on('data', (bytes) => {
  heard = Buffer.concat([heard, bytes]);
});

// Sends a request and waits for the payload of its answer, a second at most.
async function ask(command, payload) {
  heard = Buffer.alloc(0);
  port.write(Buffer.from([0x11, command, ...payload, crc8(command, payload), 0x13]));
  const deadline = AbortSignal.timeout(1000);
  const size = () => (heard.length < 2 ? Infinity : 4 + PAYLOAD_BYTES[heard[1]]);
  while (heard.length < size()) await once(port, 'data', { signal: deadline });
  const answer = heard.subarray(2, size() - 2);
  if (heard[size() - 2] !== crc8(heard[1], answer)) throw new Error('wrong CRC');
  if (heard[1] === ERROR) throw new Error(`refused with code ${answer.readInt8()}`);
  return answer;
}

await once(port, 'open');
const [major, minor] = await ask(GET_VERSION, [0x00]);
console.log(`firmware ${major}.${minor}`);
for (let i = 0; i < Number(count); ++i) {
  const state = await ask(GET_MOTOR_STATE, [MOTOR]);
  const current_a = (state.readInt32LE(8) / 1000).toFixed(3);
  console.log(`actual ${state.readInt32LE(0)} rpm, target ${state.readInt32LE(4)} rpm, ${current_a} A`);
  await new Promise((resolve) => setTimeout(resolve, 100));
}
port.close();
