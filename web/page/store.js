// What the page keeps in the storage of the browser: preferences as the text of the file that the
// desktop has, and the last recordings. Where there is no storage nothing is kept.
const PREFERENCES = 'msd.preferences';
// The oldest recordings make room for new ones beyond this many.
const MOST = 20;

export function preferences() {
  try {
    return localStorage.getItem(PREFERENCES) ?? undefined;
  } catch {
    return undefined;
  }
}

export function keepPreferences(text) {
  try {
    localStorage.setItem(PREFERENCES, text);
  } catch {
    // Full, or not allowed here.
  }
}

const result = request => new Promise((done, failed) => {
  request.onsuccess = () => done(request.result);
  request.onerror = () => failed(request.error);
});

async function store(mode) {
  const request = indexedDB.open('msd', 2);
  request.onupgradeneeded = () => upgrade(request.result, request.transaction);
  const base = await result(request);
  const transaction = base.transaction('files', mode);
  transaction.oncomplete = () => base.close();
  return transaction.objectStore('files');
}

// The bytes of recordings by date and name, so that a list of them needs no bytes. The first version
// had rows that held all three.
function upgrade(base, transaction) {
  const files = base.createObjectStore('files');
  if (!base.objectStoreNames.contains('recordings')) return;
  transaction.objectStore('recordings').openCursor().onsuccess = ({ target: { result: cursor } }) => {
    if (!cursor) return base.deleteObjectStore('recordings');
    const { name, bytes, date } = cursor.value;
    files.put(bytes, [date, name]);
    cursor.continue();
  };
}

export async function keepRecording(name, bytes) {
  const files = await store('readwrite');
  await result(files.put(bytes, [Date.now(), name]));
  const keys = await result(files.getAllKeys());
  for (const key of keys.slice(0, -MOST)) files.delete(key);
}

// Dates and names of the recordings that are kept, the newest first.
export async function recordings() {
  const keys = await result((await store('readonly')).getAllKeys());
  return keys.reverse();
}

export async function recording(key) {
  return result((await store('readonly')).get(key));
}
